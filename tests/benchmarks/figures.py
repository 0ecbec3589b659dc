"""Figure: one measured number, what is asked of it, and what others do in the same run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal


@dataclass(frozen=True)
class Figure:
    """A measured number.

    Attributes:
        what: what was measured.
        value: the number; none where it could not be measured, and then `note` says why.
        unit: its unit.
        better: whether a larger or a smaller number is better.
        must: the number it has to reach.
        peers: what others do on the same task in the same run, in the same unit.
        must_beat: how many times as good as a peer it has to be, by peer.
        note: what one should know to read it.
    """

    what: str
    value: float | None
    unit: str
    better: Literal["more", "less"]
    must: float | None = None
    peers: Mapping[str, float] = field(default_factory=dict)
    must_beat: Mapping[str, float] = field(default_factory=dict)
    note: str = ""

    def ratio(self, peer: str) -> float | None:
        """How many times as good as a peer: above 1 the peer is behind."""
        theirs = self.peers.get(peer)
        if self.value is None or not theirs or not self.value:
            return None
        return self.value / theirs if self.better == "more" else theirs / self.value

    @property
    def met(self) -> bool | None:
        """Whether everything that is asked holds; none where nothing is asked, or nothing was measured."""
        if self.value is None or (self.must is None and not self.must_beat):
            return None
        reached = self.must is None or (self.value >= self.must if self.better == "more" else self.value <= self.must)
        ratios = [(self.ratio(peer), least) for peer, least in self.must_beat.items()]
        return reached and all(ratio is None or ratio >= least for ratio, least in ratios)

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, strings and numbers, with the ratios worked out."""
        return {
            "what": self.what,
            "value": self.value,
            "unit": self.unit,
            "better": self.better,
            "must": self.must,
            "peers": {
                peer: {"value": value, "ratio": self.ratio(peer), "must_beat": self.must_beat.get(peer)}
                for peer, value in self.peers.items()
            },
            "met": self.met,
            "note": self.note,
        }


def measure(name: str) -> list[Figure]:
    """The figures of the benchmark of this name."""
    figures: list[Figure] = import_module(f"tests.benchmarks.{name}").measure()
    return figures
