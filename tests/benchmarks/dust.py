"""The scene that the engine is timed on: a box of dust falling onto a plane, in numbers that peers share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from particlecli.scene.model import Scene

STEPS = 8
FPS = 30.0
GROUP = "dust"


@dataclass(frozen=True)
class Dust:
    """Particles at random in a box 20 m wide above a plane, with random velocities.

    They fall from 0.5 to 20.5 m above it: the first ones meet it after a few frames, then ever more. The
    benchmark reports how many.

    Attributes:
        scheme: integration scheme.
        forces: two are gravity and linear drag; four add quadratic drag and a point mass in
            the middle of the box.
        contact: how impacts are located in time.
        friction: Coulomb's coefficient of the plane.
        count: how many particles.
        frames: how many frames after the first.
        height, thickness: of the middle of the box above the plane, and of the box, m.
        speed: standard deviation of each component of the velocity, m/s.
    """

    scheme: Literal["symplectic_euler", "rk4"] = "symplectic_euler"
    forces: Literal[2, 4] = 2
    contact: Literal["located", "end_of_step"] = "located"
    friction: float = 0.0
    count: int = 1 << 20
    frames: int = 24
    height: float = 10.5
    thickness: float = 20.0
    speed: float = 2.0

    gravity = 9.80665
    drag = 0.5
    quadratic_drag = 0.02
    mass_strength = 40.0
    softening = 0.5
    mass_height = 10.5
    restitution = 0.5
    dt = 1.0 / FPS / STEPS

    @property
    def particle_steps(self) -> int:
        """Steps of a frame, summed over all particles."""
        return self.count * STEPS

    def scene(self) -> Scene:
        """The scene; of its particles a kilogram each, so that coefficients by mass are the coefficients."""
        forces = [
            {"type": "gravity", "acceleration": [0.0, -self.gravity, 0.0]},
            {"type": "drag", "coefficient": self.drag},
            {"type": "quadratic_drag", "coefficient": self.quadratic_drag},
            {
                "type": "point_gravity",
                "center": [0.0, self.mass_height, 0.0],
                "strength": self.mass_strength,
                "softening": self.softening,
            },
        ]
        center, size = [0.0, self.height, 0.0], [20.0, self.thickness, 20.0]
        layout = {"type": "box", "center": center, "size": size, "count": self.count}
        speeds = {"normal": [0.0, self.speed]}
        return Scene.model_validate(
            {
                "duration": self.frames / FPS,
                "fps": FPS,
                "particles": {GROUP: {"layout": layout, "velocity": [speeds, speeds, speeds]}},
                "forces": forces[: self.forces],
                "planes": [{"restitution": self.restitution, "friction": self.friction}],
                "integrator": {"type": self.scheme, "dt": self.dt, "contact": self.contact},
                "camera": {"position": [0.0, 10.0, 34.0], "look_at": [0.0, 9.0, 0.0]},
                "look": {"groups": {GROUP: {"as": "glow", "brightness": 0.05}}},
            }
        )
