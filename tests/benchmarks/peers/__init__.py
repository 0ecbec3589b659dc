"""The same physics in other tools, as far as this machine has them."""

from __future__ import annotations

import shutil
from importlib.util import find_spec

from tests.benchmarks.contest import Peer


def available() -> dict[str, Peer]:
    """The peers this machine has, by name."""
    from tests.benchmarks.peers.numpy_loop import NumPy
    from tests.benchmarks.peers.taichi_loop import TaichiLoop

    found: dict[str, Peer] = {"NumPy": NumPy, "Taichi loop": TaichiLoop}
    if find_spec("warp"):
        from tests.benchmarks.peers.warp_loop import Warp

        found["Warp CPU"] = Warp
    if shutil.which("g++"):
        from tests.benchmarks.peers.cplusplus import CPlusPlus, UnrolledCPlusPlus

        found |= {"C++": CPlusPlus, "C++ unrolled": UnrolledCPlusPlus}
    return found
