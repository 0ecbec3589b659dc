"""A scene being simulated: its frames, one after the other. Schedules, computes nothing itself."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping

from particlecli import runtime
from particlecli.auto.resolve import resolved
from particlecli.dynamics.plan import make_plan
from particlecli.frame import Frame
from particlecli.interruption import heed
from particlecli.scene.checks import check_scene
from particlecli.scene.model import Scene


class Simulation:
    """A scene being simulated: iterate over it to get its frames, once.

    Args:
        scene: what to simulate.
        threads: worker threads, none for one a core; results do not depend on it.
        fields: for each group the optional arrays that its frames shall carry, of "velocities", "ages",
            "lifetimes" and "temperatures"; none for all that exist.

    Attributes:
        scene: what is simulated, with the scheme and step that were chosen where it left that open.
        choice: how they were chosen; none where the scene has them.
        plan: what was worked out to be needed.
        system: the state and the solver interface.
        choose_seconds, compile_seconds, simulate_seconds: wall time spent in each phase so far.

    Raises:
        SceneError: the scene's parts do not fit together, or it needs more memory than there is.
        SimulationError: while iterating: a particle is not finite any more, or the birth rate is not.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        threads: int | None = None,
        fields: Mapping[str, frozenset[str]] | None = None,
    ) -> None:
        check_scene(scene)
        began = time.perf_counter()
        self.scene, self.choice = resolved(scene, threads)
        chosen = time.perf_counter()
        self.choose_seconds = chosen - began
        self.plan = make_plan(self.scene)
        runtime.start(scene.precision, threads, self.plan.structure)
        from particlecli.dynamics.system import System

        self.system = System(self.plan)
        self.system.compile()
        self.compile_seconds = time.perf_counter() - chosen
        self.simulate_seconds = 0.0
        self._fields = fields

    @property
    def particle_steps(self) -> int:
        """Steps taken, summed over all particles."""
        return self.system.particle_steps

    @property
    def alive(self) -> int:
        """Particles alive now."""
        return self.system.alive

    @property
    def births(self) -> dict[str, int]:
        """Births so far in each group."""
        return self.system.births

    @property
    def deaths(self) -> dict[str, dict[str, int]]:
        """Deaths so far in each group, by cause."""
        return self.system.deaths

    def __iter__(self) -> Iterator[Frame]:
        for index in range(self.scene.frame_count):
            heed()
            began = time.perf_counter()
            self.system.advance(index / self.scene.fps)
            self.simulate_seconds += time.perf_counter() - began
            yield self.system.frame(index, self._fields)
