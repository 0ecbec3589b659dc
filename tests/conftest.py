"""What all tests share: Taichi loaded before they are, as runs load it, and little garbage to look through."""

import gc

import pytest

from particlecli import runtime

runtime.load()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Spares collections of garbage, which runtimes make before they start afresh, what is here to stay."""
    gc.collect()
    gc.freeze()
