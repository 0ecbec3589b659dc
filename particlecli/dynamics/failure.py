"""What is said of a particle that is not finite any more; where it was last well is found by going back."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from particlecli.dynamics.group import Group
from particlecli.dynamics.memory import FieldMemory
from particlecli.errors import SimulationError

if TYPE_CHECKING:
    from particlecli.dynamics.system import System


def failed_before(group: Group, until: float) -> SimulationError:
    """That a particle of a group fails before a time, s."""
    return SimulationError(f"group {group.plan.name}: not finite any more before t = {until:.6g} s")


def failure(system: System, group: Group, slot: int, interval: float) -> SimulationError:
    """When a particle failed, where it was last well, and what may help.

    Its steps are taken once more, one by one.

    Args:
        system: at the time at which the interval began.
        group, slot: the particle.
        interval: in which it failed, s.
    """
    steps = system.plan.steps_per_frame
    dt = interval / steps
    if system.coupled and group.plan.coupled:
        last, taken = group, system.coupled.retrace(system.time, interval, steps)
    else:
        last, taken = _retraced(group, slot, system.time, dt, steps)
    number = int(group.state.read(("id",))[0, slot]) if group.has("id") else slot
    place = slot if last is group else 0
    values = [(name, last.state.read((name,))[0, place]) for name in group.plan.motion_components]
    well = ", ".join(f"{name} = {value:.6g}" for name, value in values)
    return SimulationError(
        f"group {group.plan.name}, particle {number}: not finite any more after t = {system.time + taken * dt:.6g} s "
        f"(last good state: {well}). Try a smaller integrator.dt, a softening on forces that grow near a point, "
        f"or drop such particles with dies: {{non_finite: true}}"
    )


def _retraced(group: Group, slot: int, time: float, dt: float, steps: int) -> tuple[Group, int]:
    """A group of that particle alone where it was last well, and how many steps it took until then."""
    memory = FieldMemory()
    witness = Group(replace(group.plan, capacity=1), group.motion, group.real, memory)
    memory.open()
    witness.state.append({name: group.state.read((name,))[0, slot : slot + 1] for name in group.plan.components})
    for taken in range(steps):
        if witness.advance(time + taken * dt, dt, 1).failed_slot is not None:
            break
    return witness, taken
