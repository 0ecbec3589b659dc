"""Velocity fields: their kernels, and which specification of the scene each belongs to."""

from collections.abc import Iterable
from typing import Any, assert_never

from particlecli.dynamics.flows.abc_flow import AbcFlow
from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.flows.curl_noise import CurlNoise
from particlecli.dynamics.flows.double_gyre import DoubleGyre
from particlecli.dynamics.flows.expression import Written
from particlecli.dynamics.flows.taylor_green import TaylorGreen
from particlecli.dynamics.flows.uniform import Uniform
from particlecli.dynamics.flows.vortex import Vortex
from particlecli.scene import flows as scene

__all__ = ["FlowTerm", "flow_term", "flow_terms"]


def flow_term(spec: scene.FlowTerm, scene_seed: int = 0) -> FlowTerm[Any]:
    """The term that computes what a specification of the scene describes."""
    match spec:
        case scene.UniformFlow():
            return Uniform(spec)
        case scene.VortexFlow():
            return Vortex(spec)
        case scene.CurlNoiseFlow():
            return CurlNoise(spec, scene_seed)
        case scene.AbcFlow():
            return AbcFlow(spec)
        case scene.DoubleGyreFlow():
            return DoubleGyre(spec)
        case scene.TaylorGreenFlow():
            return TaylorGreen(spec)
        case scene.ExpressionFlow():
            return Written(spec)
        case _:
            assert_never(spec)


def flow_terms(specs: Iterable[scene.FlowTerm], scene_seed: int) -> list[FlowTerm[Any]]:
    """The terms of a flow, which add up; another `scene_seed` gives another turbulence."""
    return [flow_term(spec, scene_seed) for spec in specs]
