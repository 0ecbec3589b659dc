"""The integrator `auto`: scheme and step chosen by short pilots on a sample of the particles."""
