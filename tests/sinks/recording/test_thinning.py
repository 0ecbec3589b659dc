from __future__ import annotations

import numpy as np

from particlecli.frame import Frame, GroupFrame
from particlecli.sinks.recording.thinning import chosen


def group(ids: np.ndarray) -> GroupFrame:
    return GroupFrame(ids, np.zeros((len(ids), 3), np.float32))


def test_few_are_all_kept() -> None:
    frame = Frame(0, 0.0, {"a": group(np.arange(5))})
    assert chosen(frame, None) == chosen(frame, 5) == {"a": slice(None)}


def test_every_group_keeps_its_share_and_none_is_too_much() -> None:
    frame = Frame(0, 0.0, {"a": group(np.arange(700)), "b": group(np.arange(299)), "c": group(np.arange(1))})
    places = chosen(frame, 100)
    assert {name: len(each) for name, each in places.items()} == {"a": 70, "b": 29, "c": 0}
    assert all((np.diff(each) > 0).all() for each in places.values())


def test_the_choice_stays_while_others_die() -> None:
    alive = np.arange(1000)
    kept = alive[chosen(Frame(0, 0.0, {"a": group(alive)}), 100)["a"]]
    later = np.setdiff1d(alive, kept[:40])
    assert np.isin(kept[40:], later[chosen(Frame(1, 0.1, {"a": group(later)}), 100)["a"]]).all()


def test_the_choice_is_spread_over_all() -> None:
    kept = chosen(Frame(0, 0.0, {"a": group(np.arange(100_000))}), 10_000)["a"]
    counts = np.histogram(kept, bins=10, range=(0, 100_000))[0]
    assert (abs(counts - 1000) < 150).all()
    assert abs((kept % 2).mean() - 0.5) < 0.03
