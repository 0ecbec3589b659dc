"""Cases of parametrized tests."""

from typing import Any

import pytest


def later(*cases: Any) -> list[Any]:
    """Cases that only the longer studies look at: what they show is shown by others too, and each compiles kernels."""
    return [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow) for case in cases]
