"""Particles that merge into one body: the lit isosurface of a summed density, found in screen space."""
