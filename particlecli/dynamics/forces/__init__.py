"""Forces: their kernels, and which specification of the scene each belongs to."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, assert_never

from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.forces.drag import Drag
from particlecli.dynamics.forces.force_field import ForceField
from particlecli.dynamics.forces.gravity import Gravity
from particlecli.dynamics.forces.orbit import Orbit
from particlecli.dynamics.forces.point_gravity import PointGravity
from particlecli.dynamics.forces.quadratic_drag import QuadraticDrag
from particlecli.dynamics.forces.riding import Riding
from particlecli.dynamics.forces.vortex import Vortex
from particlecli.scene import forces as scene
from particlecli.scene.frames import CoordinateFrame, chain

__all__ = ["ForceTerm", "force_term"]


NO_FRAMES: Mapping[str, CoordinateFrame] = MappingProxyType({})


def force_term(spec: scene.UnaryForce, frames: Mapping[str, CoordinateFrame] = NO_FRAMES) -> ForceTerm[Any]:
    """The term that computes what a specification of the scene describes, with its coordinate frames."""
    term = _term(spec)
    if isinstance(spec, scene.PlacedForce) and spec.frame is not None:
        return Riding(term, chain(frames, spec.frame))
    return term


def _term(spec: scene.UnaryForce) -> ForceTerm[Any]:
    match spec:
        case scene.Gravity():
            return Gravity(spec)
        case scene.PointGravity():
            return PointGravity(spec)
        case scene.Drag():
            return Drag(spec)
        case scene.QuadraticDrag():
            return QuadraticDrag(spec)
        case scene.ForceField():
            return ForceField(spec)
        case scene.VortexForce():
            return Vortex(spec)
        case scene.OrbitForce():
            return Orbit(spec)
        case _:
            assert_never(spec)
