"""Forces between particles, and the engine that advances all particles they act on together.

Groups that no such force acts on stay with the kernels of their own, see `dynamics.group`. The others form one system
with one step for all: `points` holds them as the forces see them, `base` says what a force offers, `motion` adds
forces up, `stages` carries out schemes, and `system` runs the frames.
"""
