"""A sample of a scene's particles: some of the births of each group, with everything else as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.births import Births, SampledBirths
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.plan import Plan

GOLDEN = (5**0.5 - 1) / 2


def spread(total: int, most: int) -> NDArray[np.int64]:
    """Up to `most` of the numbers below `total`, in order, spread evenly but in step with no lattice; shape (n,).

    Multiples of the golden ratio, modulo 1: whatever the rows and layers of a grid, no row is taken alone.
    """
    if total <= most:
        return np.arange(total)
    places = (np.arange(most) + 0.5) * GOLDEN % 1.0
    return np.unique((places * total).astype(np.int64))


def chosen(births: Births, most: int) -> NDArray[np.int64]:
    """Numbers of up to `most` of the particles of a group, spread over all of its births; shape (n,)."""
    places = spread(births.total, most)
    return births.ids[places] if isinstance(births, SampledBirths) else places


def thinned(plan: Plan, most: int) -> Plan:
    """The plan of the same scene with at most so many births in each group, drawn beforehand; none bear children.

    Groups whose particles act on each other stay whole: without some of them the others would move otherwise.
    """
    return replace(plan, groups=tuple(_thinned(group, most) for group in plan.groups), broods=())


def _thinned(group: GroupPlan, most: int) -> GroupPlan:
    if group.coupled:
        return group
    births = SampledBirths(group.births, chosen(group.births, most))
    whole = births.total == group.births.total
    components = group.components if whole or "id" in group.components else (*group.components, "id")
    capacity = min(group.capacity, births.total)
    return replace(group, births=births, components=components, capacity=capacity)
