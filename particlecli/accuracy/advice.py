"""What a linear analysis means for the choice of an integrator, in sentences."""

from __future__ import annotations

import math

import numpy as np

from particlecli.accuracy.analysis import Analysis, GroupAnalysis
from particlecli.scene.integrator import Scheme
from particlecli.stability.modes import Doubles, Kind

STEPS_PER_PERIOD = 20
"""With so many, a second-order scheme has the phase of an oscillation right to half a percent."""

CHAOTIC = 3.0
"""E-folds of growth until the end after which single paths are said to be unpredictable."""


def advice(group: GroupAnalysis, frame_interval: float) -> str:
    """What rules the motion of a group and which integrator suits it.

    Args:
        group: its analysis.
        frame_interval: time from one frame to the next, s.
    """
    match group.ruler:
        case "nothing":
            sentences = _steady(group)
        case "position":
            sentences = _position(group)
        case "velocity":
            sentences = _velocity(group, frame_interval)
        case "both":
            sentences = _both(group)
        case "flow":
            sentences = _flow(group)
    return " ".join([*sentences, *_growth(group)])


def verdict(analysis: Analysis) -> str:
    """Whether the scene's own integrator is stable at its step."""
    scheme, step = analysis.scene.integrator.scheme, analysis.step
    limit = analysis.limits.get(scheme)
    if limit is None or step is None:
        return f"{scheme} chooses its steps by their error, which keeps them stable."
    if math.isinf(limit.step):
        return f"{scheme} is stable here at any step."
    taken = f"at steps of {step:.3g} s"
    if step <= limit.step:
        return f"{scheme} is stable {taken}, {step / limit.step:.2g} of the longest it can take."
    if limit.step == 0.0:
        return f"{scheme} is stable at no step: it makes that motion grow, the less the shorter the step."
    return f"{scheme} is unstable {taken}, {step / limit.step:.3g} times the longest it can take."


def _steady(group: GroupAnalysis) -> list[str]:
    if not group.newtonian:
        return ["The flow hardly changes from place to place: paths are nearly straight, and any scheme will do."]
    if group.acceleration == 0.0:
        return ["No force acts: particles fly straight on, and every scheme is exact."]
    known = "does not depend" if group.position_rate == group.velocity_rate == 0.0 else "hardly depends"
    return [
        f"The acceleration {known} on position or velocity: paths are parabolas.",
        "Every scheme of order 2 or more is right at any step; velocity_verlet costs least."
        if "velocity_verlet" in group.limits
        else "Every scheme of order 2 or more is right at any step; midpoint costs least.",
    ]


def _position(group: GroupAnalysis) -> list[str]:
    where = "it and the others are" if group.coupled else "it is"
    sentences = [f"Position rules: what pushes a particle is where {where}."]
    period = _fastest_period(group)
    if period is None:
        return [
            *sentences,
            "Nothing pulls particles back; rk4 or an adaptive scheme follows their paths well.",
        ]
    sentences.append(f"The fastest oscillation has a period of {period:.3g} s.")
    if "velocity_verlet" in group.limits:
        sentences.append(
            "A symplectic scheme such as velocity_verlet keeps its energy for ever, where euler adds some in "
            f"each step and implicit_euler takes some; it is stable {_up_to(group, 'velocity_verlet')}"
        )
    else:
        sentences.append(f"rk4 suits it, stable {_up_to(group, 'rk4')}")
    return [
        *sentences[:-1],
        f"{sentences[-1]}, and right in phase with steps of {period / STEPS_PER_PERIOD:.2g} s.",
    ]


def _velocity(group: GroupAnalysis, frame_interval: float) -> list[str]:
    period, fastest = _fastest_period(group), group.velocity_rate
    if period is not None:
        return [
            f"Velocity rules: the forces turn paths round with a period of {period:.3g} s.",
            f"Kicks and drifts are of no use there; rk4 is stable {_up_to(group, 'rk4')}, and "
            "implicit_midpoint keeps the speed at any step.",
        ]
    sentences = [f"Velocity rules: drag makes a particle forget its velocity within {1.0 / fastest:.3g} s."]
    if fastest * frame_interval < 1.0:
        return [
            *sentences,
            f"The frames show that, so it must be resolved: rk4 does, stable {_up_to(group, 'rk4')}.",
        ]
    rigid = [name for name in ("implicit_euler", "tr_bdf2", "radau_iia", "exact") if name in group.limits]
    return [
        *sentences,
        "That is stiff: over before the next frame, but an explicit scheme must follow it or blow up "
        f"(rk4 is stable {_up_to(group, 'rk4')}).",
        *([f"{' or '.join(rigid)} may take steps as long as the frames."] if rigid else []),
    ]


def _both(group: GroupAnalysis) -> list[str]:
    return [
        f"Position ({group.position_rate:.3g} 1/s) and velocity ({group.velocity_rate:.3g} 1/s) count alike.",
        "A symplectic scheme has no energy to keep where drag takes it or a flow brings it; "
        f"rk4 suits, stable {_up_to(group, 'rk4')}.",
    ]


def _flow(group: GroupAnalysis) -> list[str]:
    return [
        f"The flow rules: it turns and stretches what it carries at {group.position_rate:.3g} 1/s at most.",
        "Where it turns, euler spirals outwards at any step; midpoint hardly does, and rk4, stable "
        f"{_up_to(group, 'rk4')}, not at all.",
    ]


def _growth(group: GroupAnalysis) -> list[str]:
    rates = _of_kind(group, "growth")
    if not len(rates) or rates.max() * group.span < CHAOTIC:
        return []
    if group.coupled:
        return [
            f"In this state the fastest growth e-folds in {1.0 / rates.max():.3g} s; where that lasts, no scheme gets "
            "single paths right for much longer, only what they have in common."
        ]
    return [
        f"Nearby paths drift apart by themselves, at the fastest e-fold in {1.0 / rates.max():.3g} s: no scheme "
        "gets single paths right for much longer than that, only what they have in common."
    ]


def _fastest_period(group: GroupAnalysis) -> float | None:
    rates = np.abs(group.of_kind("oscillation").rates.imag)
    return math.tau / float(rates.max()) if len(rates) else None


def _of_kind(group: GroupAnalysis, kind: Kind) -> Doubles:
    return np.abs(group.of_kind(kind).rates.real)


def _up_to(group: GroupAnalysis, scheme: Scheme) -> str:
    """Up to which step a scheme is stable, in words."""
    step = group.limits[scheme].step
    if math.isinf(step):
        return "at any step"
    return f"up to dt = {step:.3g} s" if step else "at no step"
