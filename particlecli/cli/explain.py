"""`particlecli explain`: what would be built for a scene, and why."""

from __future__ import annotations

import json as json_module
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import typer

from particlecli.cli.columns import size, table
from particlecli.cli.options import AsJson, Overrides, SceneFile
from particlecli.cli.scenes import load

if TYPE_CHECKING:
    from particlecli.auto.outcome import Choice
    from particlecli.dynamics.group_plan import GroupPlan
    from particlecli.dynamics.plan import Plan


def command(
    scene: SceneFile,
    overrides: Overrides = None,
    json: AsJson = False,
) -> None:
    """Show what would be built for a scene, and why.

    Groups, state, forces, flows, kernels, steps and memory exist only where the scene uses them.
    """
    loaded = load(scene, overrides)
    from particlecli.dynamics.plan import make_plan

    choice = None
    if loaded.integrator.type == "auto":
        from particlecli.auto.resolve import resolved  # its pilots need Taichi, a plan does not

        loaded, choice = resolved(loaded)
    facts = explanation(make_plan(loaded), choice)
    typer.echo(json_module.dumps(facts, indent=2, ensure_ascii=False) if json else _text(facts))


def explanation(plan: Plan, choice: Choice | None = None) -> dict[str, Any]:
    """What a plan would build, as plain dictionaries, lists, strings and numbers."""
    scene = plan.scene
    fastest, stable_step = _stability(plan)
    return {
        "title": scene.title,
        "precision": scene.precision,
        "frames": scene.frame_count,
        "integrator": scene.integrator.type,
        "choice": None if choice is None else asdict(choice) | {"in_words": choice.lines()},
        "steps_per_frame": plan.steps_per_frame,
        "step_s": plan.step,
        "fastest_rate": fastest,
        "stable_step_s": stable_step,
        "kernels": len(plan.groups),
        "memory_bytes": plan.memory,
        "groups": [_group(plan, group) for group in plan.groups],
        "coupled_by": [{"type": each.force.type, "groups": list(each.groups)} for each in plan.couplings],
        "fixed": {name: scene.particles[name].frame for name in plan.fixed},
        "flows": {name: [term.type for term in terms] for name, terms in plan.flows.items()},
        "not_built": {"flows": plan.unused_flows, "groups": plan.empty_groups},
    }


def _stability(plan: Plan) -> tuple[float | None, float | None]:
    """The fastest rate of motion at birth, 1/s, and the step, s, up to which the scene's scheme is stable then.

    The rate is None where only the kernels could tell, the step where there is no limit or none is known.
    """
    from particlecli.accuracy.rates import fastest_at_birth, turns
    from particlecli.dynamics.integrators import SCHEMES
    from particlecli.stability.growth import longest_stable_steps
    from particlecli.stability.modes import Modes

    fastest = fastest_at_birth(plan)
    if not fastest:
        return fastest, None
    modes = Modes.around(fastest, turning=any(map(turns, plan.groups)))
    step = float(longest_stable_steps(SCHEMES[plan.scene.integrator.scheme], modes).min())
    return fastest, step if step < math.inf else None


def _group(plan: Plan, group: GroupPlan) -> dict[str, Any]:
    from particlecli.dynamics.group_plan import INTEGER_COMPONENTS

    return {
        "name": group.name,
        "motion": "newtonian" if group.newtonian else "first_order",
        "carried_by": group.carrier,
        "state": {name: 4 if name in INTEGER_COMPONENTS else group.real_bytes for name in group.components},
        "bytes_per_particle": group.bytes_per_particle,
        "capacity": group.capacity,
        "memory_bytes": group.memory,
        "forces": [{"type": force.type, "flow": getattr(force, "flow", None)} for force in group.forces],
        "flows": list(group.flows),
        "planes": [plane.on_hit for plane in group.planes],
        "impacts": group.impacts,
        "cooling": group.cooling is not None,
        "pins": [
            {"where": pin.where.source, "frame": pin.frame, "path": pin.path and [each.source for each in pin.path]}
            for pin in group.pins
        ],
        "children": [
            {"on": brood.rule.on, "emitter": brood.child, "count": brood.rule.count, "rate": brood.rule.rate}
            for brood in plan.broods
            if brood.parent == group.name
        ],
    }


def _text(facts: dict[str, Any]) -> str:
    steps = f"{facts['steps_per_frame']} steps of {facts['step_s']:.4g} s a frame"
    lines = [
        facts["title"] or "untitled scene",
        f"  {facts['integrator']}, {facts['precision']} precision: {steps}, {facts['frames']} frames",
        f"  {_count(facts['kernels'], 'group')}, a kernel for each; {size(facts['memory_bytes'])} of state",
    ]
    lines += [f"  {line}" for line in facts["choice"]["in_words"]] if facts["choice"] else []
    if facts["fastest_rate"] != 0.0:
        lines.append(f"  {_stability_text(facts)}")
    for group in facts["groups"]:
        lines += ["", *_group_text(group)]
    if facts["coupled_by"]:
        couplings = [(each["type"], ", ".join(each["groups"])) for each in facts["coupled_by"]]
        lines += ["", *table(("force between particles", "of groups, advanced together"), couplings)]
    if facts["fixed"]:
        fixed = [(name, frame or "the world") for name, frame in facts["fixed"].items()]
        lines += ["", *table(("fixed group, no state", "rests in"), fixed)]
    if facts["flows"]:
        flows = [(name, " + ".join(terms)) for name, terms in facts["flows"].items()]
        lines += ["", *table(("flow", "terms"), flows)]
    not_built = [
        *(f"flow {name} (nothing uses it)" for name in facts["not_built"]["flows"]),
        *(f"group {name} (nothing is ever born)" for name in facts["not_built"]["groups"]),
    ]
    if not_built:
        lines += ["", "  not built: " + ", ".join(not_built)]
    return "\n".join(lines)


def _stability_text(facts: dict[str, Any]) -> str:
    rate, step = facts["fastest_rate"], facts["stable_step_s"]
    if rate is None:
        return "`particlecli analyze` tells at which steps that is stable"
    rates = f"rates up to {rate:.3g} 1/s at birth"
    if step is None:
        return f"{rates}: stable at any step"
    known = f": stable up to {step:.3g} s at least" if step else ""
    return f"{rates}{known}; `particlecli analyze` tells more"


def _group_text(group: dict[str, Any]) -> list[str]:
    forces = [force["type"] + (f" in {force['flow']}" if force["flow"] else "") for force in group["forces"]]
    moved = f"carried by {group['carried_by']}" if group["carried_by"] else ", ".join(forces) or "no force"
    memory = f"{group['bytes_per_particle']} bytes = {size(group['memory_bytes'])}"
    lines = [
        f"  {group['name']}: {group['motion']}, {moved}",
        f"    up to {group['capacity']:,} at once × {memory}",
        "    state " + ", ".join(f"{name} {count}" for name, count in group["state"].items()),
    ]
    if group["planes"]:
        when = "at the ends of steps" if group["impacts"] == "end_of_step" else "at their instants"
        lines.append(f"    planes {', '.join(group['planes'])}; impacts {when}")
    if group["cooling"]:
        lines.append("    cools")
    for pin in group["pins"]:
        path = f"goes along {', '.join(pin['path'])}" if pin["path"] else "stays"
        lines.append(f"    pinned where {pin['where']}, {path} in {pin['frame'] or 'the world'}")
    for rule in group["children"]:
        number = f"{rule['count']:,} at each {rule['on']}" if rule["count"] else f"{rule['rate']:g} a second"
        lines.append(f"    bears {rule['emitter']}, {number}")
    return lines


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
