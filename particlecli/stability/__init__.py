"""Modes of linearized motion, and how long steps may be for a scheme to be stable."""
