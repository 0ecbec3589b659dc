"""Shorter ways through Taichi 1.7: all of its own functions that are replaced are replaced here.

What they leave out serves its messages about faulty kernels, or is done anew each time though nothing has changed. The
results are the same, bit by bit.
"""

from particlecli.taichi_shortcuts import calls, tracing


def take() -> None:
    """Take them from now on in this process."""
    calls.take()
    tracing.take()
