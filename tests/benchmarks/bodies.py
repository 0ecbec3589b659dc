"""A million spheres and a million sprites at 1280×720, beside as many glow dots."""

from __future__ import annotations

from particlecli.render.renderer import Renderer
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.dust import GROUP, Dust
from tests.benchmarks.figures import Figure
from tests.benchmarks.render import fastest

SLOWEST = 150.0
"""ms."""

GLOW = "1M glow dots"

LOOKS = {
    GLOW: {"as": "glow", "brightness": 0.05},
    "1M spheres": {"as": "spheres", "radius": 0.03},
    "1M clear spheres": {"as": "spheres", "radius": 0.03, "opacity": 0.3},
    "1M sprites": {"as": "sprites", "radius": 0.05},
}


def measure() -> list[Figure]:
    """Milliseconds a picture of each look."""
    scene = Dust(frames=1).scene()
    simulation = Simulation(scene)
    *_, frame = simulation
    renderers = {name: Renderer(_looking(scene, look)) for name, look in LOOKS.items()}
    tasks = {name: lambda renderer=renderer: renderer.render(frame) for name, renderer in renderers.items()}
    seconds = fastest(tasks)
    peer = {GLOW: 1e3 * seconds.pop(GLOW)}
    return [Figure(name, 1e3 * time, "ms", "less", must=SLOWEST, peers=peer) for name, time in seconds.items()]


def _looking(scene: Scene, look: dict[str, object]) -> Scene:
    groups = {GROUP: GroupLook.model_validate(look)}
    return scene.model_copy(update={"planes": (), "look": scene.look.model_copy(update={"groups": groups})})
