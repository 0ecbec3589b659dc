from __future__ import annotations

import pytest

from particlecli import runtime


@pytest.fixture(autouse=True)
def _taichi() -> None:
    runtime.start("single", 2)
