"""Benchmarks with their peers, all run by `python -m tests.benchmarks [NAME …]`."""
