"""Which term belongs to which specification of the scene."""

from collections.abc import Sequence
from typing import Any, assert_never

from particlecli.dynamics.coupled.attraction import Attraction
from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.coupled.body_drag import BodyDrag
from particlecli.dynamics.coupled.lennard_jones import LennardJones
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.rough_sphere import RoughSphere
from particlecli.dynamics.coupled.soft_sphere import SoftSphere
from particlecli.dynamics.coupled.sph import Sph
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.coupled.tree_attraction import TreeAttraction
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.scene import forces as scene


def coupled_term(
    spec: scene.CoupledForce, points: Points, groups: Sequence[int], plans: Sequence[GroupPlan]
) -> CoupledTerm[Any]:
    """The term that computes what a specification of the scene describes.

    Args:
        spec, points, groups: as of `CoupledTerm`.
        plans: of all groups of `points`, in their order.
    """
    match spec:
        case scene.Attraction():
            if spec.uses_tree(sum(plans[group].capacity for group in groups)):
                return TreeAttraction(spec, points, groups)
            return Attraction(spec, points, groups)
        case scene.Springs():
            return Springs(spec, points, groups, plans)
        case scene.BodyDrag():
            return BodyDrag(spec, points, groups, plans)
        case scene.LennardJones():
            return LennardJones(spec, points, groups)
        case scene.SoftSphere():
            return RoughSphere(spec, points, groups) if spec.friction > 0.0 else SoftSphere(spec, points, groups)
        case scene.Sph():
            planes = dict.fromkeys(plane for group in groups for plane in plans[group].planes)
            return Sph(spec, points, groups, list(planes))
        case _:
            assert_never(spec)
