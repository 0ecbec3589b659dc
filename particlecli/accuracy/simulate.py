"""simulate(scene): the frames of a scene, one after the other, unless its step would blow the motion up."""

from __future__ import annotations

from collections.abc import Iterator

from particlecli.accuracy.refusal import refuse_unstable
from particlecli.frame import Frame
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation


def simulate(scene: Scene, *, threads: int | None = None) -> Iterator[Frame]:
    """The frames of a scene at times 0, 1/fps, … up to its duration.

    Args:
        scene: what to simulate.
        threads: worker threads, none for one a core; results do not depend on it.

    Raises:
        SceneError: the scene's parts do not fit together, or it needs more memory than there is.
        SimulationError: the step is so long that the scheme would blow the motion up, see `refuse_unstable`; or,
            while iterating, a particle is not finite any more, or the birth rate is not.
    """
    simulation = Simulation(scene, threads=threads)
    refuse_unstable(simulation)
    return iter(simulation)
