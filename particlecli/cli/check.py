"""`particlecli check`: how far runs are from what is known of them, and from an independent judge."""

from __future__ import annotations

import json as json_module
import math
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from particlecli.cli.columns import table
from particlecli.cli.console import message
from particlecli.cli.options import AsJson, Overrides, SceneFiles, Threads
from particlecli.cli.progress import progress
from particlecli.cli.scenes import load
from particlecli.errors import CheckFailedError, ParticleError, UsageError

if TYPE_CHECKING:
    from particlecli.accuracy.judge import Deviation, Judgement
    from particlecli.accuracy.references import Comparison
    from particlecli.scene.model import Scene

Unit = Literal["m", "px"]

HEADER = ("what", "known", "found", "error", "tolerance", "verdict")


@dataclass(frozen=True)
class Limit:
    """The largest distance from the judge that passes, in metres or in pixels of the scene's picture."""

    size: float
    unit: Unit

    def __str__(self) -> str:
        return f"{self.size:g} {self.unit}"

    def keeps(self, deviation: Deviation) -> bool:
        """Whether a deviation is within it."""
        found = deviation.pixels if self.unit == "px" else deviation.metres
        return found is not None and found <= self.size


@dataclass(frozen=True)
class Outcome:
    """What came out for one scene: known answers, and groups beside the judge."""

    path: Path
    scene: Scene
    known: list[Comparison]
    judged: list[Judgement]
    limit: Limit

    @property
    def verdicts(self) -> list[bool]:
        """Whether each comparison passes."""
        return [each.passed for each in self.known] + [self.agrees(each) for each in self.judged]

    def agrees(self, judgement: Judgement) -> bool:
        """Whether a group is everywhere where the judge says, and nothing lives that should not."""
        largest = judgement.largest
        return not judgement.outlived and (largest is None or self.limit.keeps(largest))


def command(
    scenes: SceneFiles,
    against: Annotated[
        Literal["scipy"] | None,
        typer.Option(help="Compare all particles at all frames with SciPy's DOP853 in double precision too."),
    ] = None,
    tolerance: Annotated[
        str, typer.Option(metavar="T", help="Largest distance from SciPy's that passes: 0.5 px, 1e-6 m.")
    ] = "0.5 px",
    overrides: Overrides = None,
    threads: Threads = None,
    json: AsJson = False,
) -> None:
    """Run scenes and compare them with the answers that are known, which they list under `reference`.

    The exit code is 1 where an error is past its tolerance.
    """
    limit = _limit(tolerance)
    outcomes: list[Outcome] = []
    worst = 0
    for path in scenes:
        try:
            outcome = _outcome(path, load(path, overrides), against, limit, threads)
        except ParticleError as error:
            message(f"{path}: {error}" if str(path) not in str(error) else str(error))
            worst = max(worst, error.exit_code)
            continue
        outcomes.append(outcome)
        if not json:
            typer.echo("\n".join(_text(outcome)) + "\n")
    if json:
        typer.echo(json_module.dumps(_facts(outcomes), indent=2, ensure_ascii=False))
    if worst:
        raise typer.Exit(worst)
    verdicts = [verdict for outcome in outcomes for verdict in outcome.verdicts]
    if not all(verdicts):
        raise CheckFailedError(f"{verdicts.count(False)} of {len(verdicts)} comparisons are past their tolerance")


def _limit(text: str) -> Limit:
    found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(m|px)?\s*", text)
    try:
        size = float(found[1]) if found else math.nan
    except ValueError:
        size = math.nan
    if found is None or not 0 < size < math.inf:
        raise UsageError(f'--tolerance {text}: must be a distance such as "0.5 px" or "1e-6 m"')
    return Limit(size, "px" if found[2] == "px" else "m")


def _outcome(path: Path, scene: Scene, against: str | None, limit: Limit, threads: int | None) -> Outcome:
    if not scene.reference and against is None:
        raise UsageError(
            f"{path}: nothing is known of its result; give the scene a `reference`, or say --against scipy"
        )
    from particlecli.accuracy.references import compare_with_known

    known = compare_with_known(scene, threads=threads) if scene.reference else []
    judged: list[Judgement] = []
    if against is not None:
        from particlecli.accuracy.judge import judge
        from particlecli.run import Progress

        with progress(quiet=False, what="SciPy at") as show:
            assert show
            judged = judge(
                scene, threads=threads, show=lambda done, alive: show(Progress(done, scene.frame_count, alive))
            )
        unseen = [each.group for each in judged if each.largest is not None and each.largest.pixels is None]
        if unseen and limit.unit == "px":
            raise UsageError(f"{path}: no particle of {unseen[0]} is ever in the picture; give --tolerance in metres")
    return Outcome(path, scene, known, judged, limit)


def _text(outcome: Outcome) -> list[str]:
    rows = [_known_row(each) for each in outcome.known]
    for judgement in outcome.judged:
        rows += _judged_rows(judgement, outcome)
    return [f"{outcome.path}  {outcome.scene.title}".rstrip(), *table(HEADER, rows)]


def _known_row(comparison: Comparison) -> tuple[str, ...]:
    whose = f"{comparison.group}" if comparison.particle is None else f"{comparison.group} {comparison.particle}"
    unit = "relative" if comparison.relative else comparison.unit
    return (
        f"{whose}: {comparison.quantity} at {comparison.at:.10g} s",
        _numbers(comparison.expected),
        _numbers(comparison.found) if not comparison.trouble else comparison.trouble,
        f"{comparison.error:.2g} {unit}".rstrip(),
        f"{comparison.tolerance:.2g} {unit}".rstrip(),
        _verdict(comparison.passed),
    )


def _judged_rows(judgement: Judgement, outcome: Outcome) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for deviation, when in ((judgement.final, "at the end"), (judgement.largest, "at worst")):
        if deviation is not None:
            pixels = "" if deviation.pixels is None else f", {deviation.pixels:.2g} px"
            where = f"{judgement.group} {deviation.particle}, {deviation.time:.6g} s"
            verdict = _verdict(outcome.limit.keeps(deviation))
            error = f"{deviation.metres:.2g} m{pixels}"
            rows.append((f"{where}: position {when}", "SciPy", "", error, str(outcome.limit), verdict))
    if judgement.outlived:
        what = f"{judgement.group}: particles that a plane had killed"
        rows.append((what, "0", str(judgement.outlived), "", "", _verdict(False)))
    return rows


def _numbers(values: tuple[float, ...]) -> str:
    text = ", ".join(f"{value:.7g}" for value in values)
    return f"({text})" if len(values) > 1 else text


def _verdict(passed: bool) -> str:
    return "ok" if passed else "FAILED"


def _facts(outcomes: list[Outcome]) -> dict[str, Any]:
    scenes = [
        {
            "scene": str(outcome.path),
            "title": outcome.scene.title,
            "passed": all(outcome.verdicts),
            "known": [_plain(asdict(each) | {"passed": each.passed}) for each in outcome.known],
            "tolerance": str(outcome.limit),
            "against_scipy": [_plain(asdict(each) | {"passed": outcome.agrees(each)}) for each in outcome.judged],
        }
        for outcome in outcomes
    ]
    return {"passed": all(scene["passed"] for scene in scenes), "scenes": scenes}


def _plain(value: Any) -> Any:
    """The same for JSON, which has no infinite numbers."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
