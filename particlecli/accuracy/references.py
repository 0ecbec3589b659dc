"""A scene's run against the answers that are known of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from particlecli.accuracy.measure import Doubles, Ids, Sample
from particlecli.accuracy.refusal import refuse_unstable
from particlecli.scene.known_answers import KnownAnswer, Relative, Statistic
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

ROUNDING = 1e-9
"""How near a frame a known answer belongs to it, in frames."""

STATISTICS: dict[Statistic, Callable[[Doubles], np.floating[Any]]] = {
    "min": np.min,
    "max": np.max,
    "mean": np.mean,
    "rms": lambda values: np.sqrt(np.mean(values**2)),
    "sum": np.sum,
}


@dataclass(frozen=True)
class Comparison:
    """A known value and the one that was found; of several particles, those of the one furthest off.

    Attributes:
        group, at: whose, and when, s.
        quantity: what is compared: "position", "velocity", "energy", an expression or a statistic of one.
        unit: of the numbers; empty where the expression tells.
        particle: number of the particle; none for what belongs to all together.
        expected, found: one number, or three; empty where there is nothing to compare.
        error: absolute, or in parts of the known value; infinite where there is nothing to compare.
        tolerance, relative: the largest error that passes, and whether both are in parts of the known value.
        source: how the answer is known.
        trouble: why there is nothing to compare.
    """

    group: str
    at: float
    quantity: str
    unit: str
    particle: int | None
    expected: tuple[float, ...]
    found: tuple[float, ...]
    error: float
    tolerance: float
    relative: bool
    source: str
    trouble: str = ""

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.tolerance


def compare_with_known(scene: Scene, *, threads: int | None = None) -> list[Comparison]:
    """Run a scene up to its last known answer, in its own precision and steps, and compare them all.

    A frame within which an answer is known is cut in two there, each part with the steps of a whole frame.

    Returns:
        For each answer, in their order, a comparison of each value it gives.

    Raises:
        SceneError, SimulationError: as `simulate`.
    """
    simulation = Simulation(scene, threads=threads)
    refuse_unstable(simulation)
    found: dict[int, list[Comparison]] = {}
    for time in _instants(scene):
        simulation.system.advance(time)
        for number, answer in enumerate(scene.reference):
            if answer.at == time:
                found[number] = list(_compared(Sample.of(simulation, answer.group), answer))
    return [comparison for number in sorted(found) for comparison in found[number]]


def _instants(scene: Scene) -> list[float]:
    """The times of frames and known answers up to the last of these, s."""
    known = sorted({answer.at for answer in scene.reference})
    if not known:
        return []
    frames = [index / scene.fps for index in range(math.ceil(known[-1] * scene.fps))]
    apart = ROUNDING / scene.fps
    return sorted([*known, *(time for time in frames if min(abs(time - each) for each in known) > apart)])


def _compared(alive: Sample, answer: KnownAnswer) -> Iterator[Comparison]:
    sample, trouble = _meant(alive, answer)
    if trouble:
        yield _comparison(answer, "particles", "", trouble=trouble)
        return
    positions = answer.positions if answer.position is None else (answer.position,)
    velocities = answer.velocities if answer.velocity is None else (answer.velocity,)
    if positions is not None:
        yield _of_each(answer, "position", "m", sample.ids, np.array(positions), sample.positions)
    if velocities is not None and sample.velocities is not None:
        yield _of_each(answer, "velocity", "m/s", sample.ids, np.array(velocities), sample.velocities)
    if answer.energy is not None:
        yield _of_all(answer, "energy", "J", answer.energy, sample.energy())
    if answer.quantity is not None and answer.value is not None:
        values = sample.quantity(answer.quantity)
        if answer.of_all is None:
            known = np.array([[answer.value]])
            yield _of_each(answer, answer.quantity.source, "", sample.ids, known, values[:, None])
        else:
            name = f"{answer.of_all} of {answer.quantity.source}"
            yield _of_all(answer, name, "", answer.value, float(STATISTICS[answer.of_all](values)))


def _meant(alive: Sample, answer: KnownAnswer) -> tuple[Sample, str]:
    """The particles that an answer is about, and why there is nothing to compare; empty if there is."""
    dead = np.setdiff1d(answer.particles or (), alive.ids)
    if len(dead):
        return alive, f"particle {int(dead[0])} is not alive"
    sample = alive if answer.particles is None else alive.chosen(np.array(answer.particles))
    if not len(sample.ids):
        return sample, "no particle is alive"
    if answer.where is not None:
        sample = sample.chosen(sample.ids[sample.quantity(answer.where) > 0])
        if not len(sample.ids):
            return sample, f"there is no particle where {answer.where.source}"
    there = "are alive" if answer.where is None else "are there"
    for values in (answer.positions, answer.velocities):
        if values is not None and len(values) != len(sample.ids):
            return sample, f"{len(sample.ids)} particles {there}, {len(values)} are known"
    return sample, ""


def _of_each(answer: KnownAnswer, quantity: str, unit: str, ids: Ids, known: Doubles, found: Doubles) -> Comparison:
    """The particle furthest off; what is known has as many rows as particles, or one for all of them."""
    errors = np.linalg.norm(found - known, axis=1)
    if isinstance(answer.tolerance, Relative):
        errors = errors / np.linalg.norm(known, axis=1)
    worst = int(np.argmax(np.where(np.isnan(errors), np.inf, errors)))
    expected = np.broadcast_to(known, found.shape)[worst]
    return _comparison(
        answer,
        quantity,
        unit,
        int(ids[worst]),
        tuple(expected.tolist()),
        tuple(found[worst].tolist()),
        float(errors[worst]),
    )


def _of_all(answer: KnownAnswer, quantity: str, unit: str, known: float, found: float) -> Comparison:
    error = abs(found - known) / (abs(known) if isinstance(answer.tolerance, Relative) else 1.0)
    return _comparison(answer, quantity, unit, None, (known,), (found,), error)


def _comparison(
    answer: KnownAnswer,
    quantity: str,
    unit: str,
    particle: int | None = None,
    expected: tuple[float, ...] = (),
    found: tuple[float, ...] = (),
    error: float = math.inf,
    trouble: str = "",
) -> Comparison:
    return Comparison(
        group=answer.group,
        at=answer.at,
        quantity=quantity,
        unit=unit,
        particle=particle,
        expected=expected,
        found=found,
        error=error,
        tolerance=answer.tolerance.size,
        relative=isinstance(answer.tolerance, Relative),
        source=answer.source,
        trouble=trouble,
    )
