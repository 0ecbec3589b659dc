"""The report of a run, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from particlecli.cli.columns import size, table
from particlecli.report import Report

if TYPE_CHECKING:
    from particlecli.accuracy.estimate import GroupError
    from particlecli.accuracy.trends import Trend

DOUBTS: dict[Trend, str] = {
    "chaotic": "shorter steps lead elsewhere: single paths mean nothing here, only what they have in common",
    "irregular": "the error does not fall with the step as it should; take it as an order of magnitude",
    "unsettled": "longer steps lead elsewhere: chaotic, or steps near the longest that are stable; --estimate tells",
    "unchecked": "a single comparison, not told whether shorter steps lead to one solution",
}
"""What to say of errors that are not what they are usually."""

NOTABLE = 0.001
"""A share of particles alive in one solution alone that is worth a line."""


def summary(report: Report) -> str:
    """What a person wants to know after a run."""
    pace = _big(report.particle_steps_per_second)
    lines = [
        report.title or "untitled scene",
        f"  frames  {report.frames} at {report.fps:g} a second{_pictures(report)}",
        f"  scheme  {report.integrator}{_step(report)}",
        f"  steps   {_big(report.particle_steps)} particle-steps, {pace} a second",
        f"  time    {_times(report)}",
    ]
    if report.births:
        header = ("group", "born", "alive", "bytes each", "error", "largest", "on screen", "died")
        lines += ["", *table(header, [_group(report, name) for name in report.births])]
    if report.estimated_error or report.not_estimated:
        lines += ["", *_errors(report)]
    late = ", ".join(name for name, contact in report.impacts.items() if contact == "end_of_step")
    if late:
        lines += ["", f"  impacts on planes: at the ends of steps, not at their instants ({late})"]
    if report.conserved:
        drifts = ", ".join(f"{name} to {drift:.1e}" for name, drift in report.conserved.items())
        lines += ["", f"  kept: {drifts} of what is in motion"]
    if report.files:
        lines += ["", *(f"  wrote {file}" for file in report.files)]
    return "\n".join(lines)


def _group(report: Report, name: str) -> tuple[str, ...]:
    births, deaths = report.births[name], report.deaths.get(name, {})
    causes = ", ".join(f"{count:,} {cause}" for cause, count in deaths.items() if count)
    alive = births - sum(deaths.values())
    size = str(report.bytes_per_particle.get(name, 0))
    return name, f"{births:,}", f"{alive:,}", size, *_error(report.estimated_error.get(name)), causes or "–"


def _error(error: GroupError | None) -> tuple[str, str, str]:
    """Of 95 in 100 particles, of the one furthest off, and of 95 in 100 on the picture."""
    if error is None:
        return "–", "–", "–"
    pixels = "–" if error.pixels is None else f"{error.pixels.p95:.2g} px"
    return f"{error.metres.p95:.1e} m", f"{error.metres.largest:.1e} m", pixels


def _errors(report: Report) -> list[str]:
    """What the estimated errors are, and which of them are not to be relied on."""
    errors = report.estimated_error
    lines = ["  error: estimated from a sample carried again in other steps; of 95 in 100 particles"] if errors else []
    if report.not_estimated:
        from particlecli.accuracy.bound import MOST_TOGETHER

        lines.append(
            f"  error not estimated: {', '.join(report.not_estimated)}: more than 5 % of this run; "
            f"--estimate does it at any cost, but for over {MOST_TOGETHER:,} particles that act on each other"
        )
    for trend, meaning in DOUBTS.items():
        names = ", ".join(name for name, error in errors.items() if error.trend == trend)
        if names:
            lines.append(f"  {names}: {meaning}")
    lines += [
        f"  {name}: {error.alone:.1%} were alive in one of the two solutions alone"
        for name, error in errors.items()
        if error.alone > NOTABLE
    ]
    return lines


def _step(report: Report) -> str:
    step = "" if report.step_s is None else f", steps of {report.step_s:.4g} s"
    return step + (", chosen by auto" if report.choice else "")


def _pictures(report: Report) -> str:
    if report.resolution is None:
        return ""
    width, height = report.resolution
    return f", {width}×{height} pixels" + (", draft" if report.quality == "draft" else "")


def _times(report: Report) -> str:
    phases = report.phases
    parts = {
        **({} if report.choice is None else {"choose": phases.choose_s}),
        "compile": phases.compile_s,
        "simulate": phases.simulate_s,
        "estimate": phases.estimate_s,
        "render": phases.render_s,
        "encode": phases.encode_s,
    }
    spent = ", ".join(f"{name} {seconds:.2f}" for name, seconds in parts.items())
    return f"{phases.wall_s:.2f} s: {spent}; memory for particles {size(report.memory)}"


def _big(count: float) -> str:
    for limit, letter in ((1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")):
        if count >= limit:
            return f"{count / limit:.3g} {letter}"
    return f"{count:.0f}"
