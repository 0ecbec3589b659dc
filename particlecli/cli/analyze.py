"""`particlecli analyze`: the modes of a scene's motion, and at which steps each integrator is stable."""

from __future__ import annotations

import json as json_module
import math
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from particlecli.cli.columns import table
from particlecli.cli.options import AsJson, Overrides, SceneFile, Threads
from particlecli.cli.scenes import load
from particlecli.errors import UsageError

if TYPE_CHECKING:
    from particlecli.accuracy.analysis import Analysis, GroupAnalysis, Limit

_WIDTH = 100
_KINDS = {"oscillation": "period", "decay": "1/e in", "growth": "× e in"}
_PICTURES = (".svg", ".png", ".pdf")


def command(
    scene: SceneFile,
    at: Annotated[
        float, typer.Option(metavar="TIME", help="When to look, s; the scene is simulated up to there.")
    ] = 0.0,
    overrides: Overrides = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Plot the stability regions and the modes: .svg, .png or .pdf."),
    ] = None,
    threads: Threads = None,
    json: AsJson = False,
) -> None:
    """Show how a scene moves, linearized, and at which steps each integrator is stable.

    At t = 0 the particles of emitters are looked at as they are born. Of particles that act on each other the modes
    are those of all of them together; of many, the fastest of each kind.
    """
    if plot is not None and plot.suffix not in _PICTURES:
        raise UsageError(f"--plot {plot}: the name must end in {', '.join(_PICTURES)}")
    loaded = load(scene, overrides)
    from particlecli.accuracy.linear_analysis import analyze

    analysis = analyze(loaded, at=at, threads=threads)
    if plot is not None:
        from particlecli.accuracy.stability_plot import plot_stability

        plot_stability(analysis, plot)
    facts = explanation(analysis)
    typer.echo(json_module.dumps(facts, indent=2, ensure_ascii=False) if json else _text(facts))


def explanation(analysis: Analysis) -> dict[str, Any]:
    """An analysis as plain dictionaries, lists, strings and numbers; an infinite step is None."""
    from particlecli.accuracy.advice import verdict

    scene = analysis.scene
    return {
        "title": scene.title,
        "time_s": analysis.time,
        "integrator": scene.integrator.type,
        "step_s": analysis.step,
        "groups": [_group(group, 1.0 / scene.fps) for group in analysis.groups],
        "stable_up_to": {scheme: _limit(limit) for scheme, limit in analysis.limits.items()},
        "verdict": verdict(analysis),
    }


def _group(group: GroupAnalysis, frame_interval: float) -> dict[str, Any]:
    from particlecli.accuracy.advice import advice

    kinds = ("free", *_KINDS)
    return {
        "name": group.name,
        "motion": "newtonian" if group.newtonian else "first_order",
        "particles": group.particles,
        "sampled": group.sampled,
        "linear": group.linear,
        "coupled": group.coupled,
        "complete": group.complete,
        "acceleration" if group.newtonian else "speed": group.acceleration,
        "position_rate": group.position_rate,
        "velocity_rate": group.velocity_rate,
        "rules": group.ruler,
        "modes": {kind: modes for kind in kinds if (modes := _modes(group, kind))["count"]},
        "stable_up_to": {scheme: _limit(limit) for scheme, limit in group.limits.items()},
        "advice": advice(group, frame_interval),
    }


def _modes(group: GroupAnalysis, kind: Any) -> dict[str, Any]:
    """How many modes are of a kind, and from how slow to how fast: frequencies, or rates."""
    rates = group.of_kind(kind).rates
    speeds = [abs(rate.imag) / math.tau if kind == "oscillation" else abs(rate.real) for rate in rates.tolist()]
    return {
        "count": len(speeds),
        "unit": "Hz" if kind == "oscillation" else "1/s",
        "from": min(speeds, default=0.0),
        "to": max(speeds, default=0.0),
    }


def _limit(limit: Limit) -> dict[str, Any]:
    from particlecli.stability.modes import describe

    if limit.rate is None:
        return {"step_s": None, "because_of": None, "rate": None, "group": None}
    return {
        "step_s": limit.step,
        "because_of": describe(limit.rate),
        "rate": [limit.rate.real, limit.rate.imag],
        "group": limit.group,
    }


def _text(facts: dict[str, Any]) -> str:
    lines = [f"{facts['title'] or 'untitled scene'}: linear analysis at t = {facts['time_s']:g} s"]
    for group in facts["groups"]:
        lines += ["", *_group_text(group)]
    if not facts["groups"]:
        return "\n".join([*lines, "", "  nothing is there then"])
    rows = [_limit_row(facts, scheme, limit) for scheme, limit in facts["stable_up_to"].items()]
    present = "" if facts["step_s"] is None else f"at {facts['step_s']:.3g} s"
    header = ("integrator", "stable up to", "because of", present)
    return "\n".join([*lines, "", *table(header, rows), "", f"  {facts['verdict']}"])


def _group_text(group: dict[str, Any]) -> list[str]:
    about = f"{group['particles']:,} particle" + ("" if group["particles"] == 1 else "s")
    if group["coupled"]:
        about += " that act on each other" + ("" if group["complete"] else ", their fastest modes")
    elif group["sampled"] < group["particles"]:
        about += f", {group['sampled']} of them looked at"
    position, velocity = (f"{group[name]:.3g} 1/s" for name in ("position_rate", "velocity_rate"))
    if "speed" in group:
        about += f"; speed {group['speed']:.3g} m/s, |∂u/∂x| {position}"
    else:
        about += f"; acceleration {group['acceleration']:.3g} m/s², √|∂a/∂x| {position}, |∂a/∂v| {velocity}"
    total = sum(modes["count"] for modes in group["modes"].values())
    rows = [
        (
            kind,
            f"{100.0 * modes['count'] / total:.0f} %" if group["complete"] else f"{modes['count']} found",
            *_range(kind, modes),
        )
        for kind, modes in group["modes"].items()
    ]
    return [
        f"  {group['name']}: {about}" + ("; linear" if group["linear"] else ""),
        *table(("motion", "modes", "rate", "time"), rows, indent="    "),
        *textwrap.wrap(group["advice"], _WIDTH, initial_indent="    ", subsequent_indent="    "),
    ]


def _range(kind: str, modes: dict[str, Any]) -> tuple[str, str]:
    """From how slow to how fast modes are, and how long that takes."""
    if kind == "free":
        return "0", "–"
    low, high = modes["from"], modes["to"]
    return f"{_span(low, high)} {modes['unit']}", f"{_KINDS[kind]} {_span(1.0 / high, 1.0 / low)} s"


def _span(low: float, high: float) -> str:
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} … {high:.3g}"


def _limit_row(facts: dict[str, Any], scheme: str, limit: dict[str, Any]) -> tuple[str, ...]:
    from particlecli.scene.integrator import ADAPTIVE

    name = f"{scheme} (the scene's)" if scheme == facts["integrator"] else scheme
    step, present, because = limit["step_s"], facts["step_s"], limit["because_of"] or "–"
    if limit["group"] and len(facts["groups"]) > 1:
        because += f" of {limit['group']}"
    reach = "any step" if step is None else f"{step:.3g} s" if step else "no step"
    if scheme in ADAPTIVE:
        return name, reach, because, "chooses its own"
    if present is None:
        return name, reach, because, ""
    return name, reach, because, "stable" if step is None or present <= step else "unstable"
