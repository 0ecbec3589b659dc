"""Loads Taichi before the tests do, as runs do."""

from particlecli import runtime

runtime.load()
