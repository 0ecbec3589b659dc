"""A million particles, gravity, linear drag and one plane, symplectic Euler, eight steps a frame."""

from __future__ import annotations

from collections.abc import Mapping

from tests.benchmarks.contest import Ours, Peer, contest
from tests.benchmarks.dust import Dust
from tests.benchmarks.figures import Figure
from tests.benchmarks.peers import available
from tests.benchmarks.peers.numpy_loop import share_that_meets_plane

LEAST = {"C++": 1.29, "NumPy": 30.0, "Warp CPU": 4.0}
"""How many times as fast as each peer the engine has to be."""

SETTLED = Dust(height=0.0, thickness=0.0, speed=0.0, frames=6)


def measure() -> list[Figure]:
    """Particle-steps a second with impacts located in time and at the end of a step."""
    peers = available()
    unrolled = {name: peer for name, peer in peers.items() if name == "C++ unrolled"}
    start = Ours(Dust(count=100_000)).state()
    meets = share_that_meets_plane(Dust(), start)
    return [
        race("impacts located in time", Dust(), peers, LEAST, note=f"{meets:.1%} meet the plane in a frame"),
        race("impacts at the end of a step", Dust(contact="end_of_step"), peers, LEAST),
        race("located, friction", Dust(friction=0.3), unrolled),
        race("end of step, friction", Dust(contact="end_of_step", friction=0.3), unrolled),
        race("located, all far above the plane", Dust(height=1000.0), unrolled),
        race("located, all at rest on the plane", SETTLED, unrolled),
    ]


def race(
    what: str, dust: Dust, peers: Mapping[str, Peer], least: Mapping[str, float] | None = None, note: str = ""
) -> Figure:
    """Particle-steps a second of ours and of peers that advance the same particles in turn."""
    results = contest(dust, peers)
    others = {name: result for name, result in results.items() if name != "ours"}
    apart = ", ".join(f"{name} {result.apart:.2%}" for name, result in others.items())
    return Figure(
        what=what,
        value=results["ours"].rate / 1e6,
        unit="M/s",
        better="more",
        peers={name: result.rate / 1e6 for name, result in others.items()},
        must_beat={name: ratio for name, ratio in (least or {}).items() if name in others},
        note="; ".join(filter(None, [note, f"end over 1 mm from ours: {apart}"])),
    )
