"""The formulas of the forces, written again in NumPy from the words of the scene language, and cases."""

from dataclasses import dataclass, field

import numpy as np
from pydantic import TypeAdapter

from particlecli.scene import forces as scene
from tests.dynamics.harness import Points

COUNT = 3000


def some_points(seed=40):
    """Points at which nothing is special."""
    random = np.random.default_rng(seed)
    return Points(
        x=random.uniform(-2, 2, (3, COUNT)),
        v=random.uniform(-3, 3, (3, COUNT)),
        u=random.uniform(-3, 3, (3, COUNT)),
        t=random.uniform(0.1, 3, COUNT),
        inverse_mass=random.uniform(0.3, 4, COUNT),
    )


def spec(**parts):
    return TypeAdapter(scene.Force).validate_python(parts)


def norm(vectors):
    return np.linalg.norm(vectors, axis=0)


def column(vector):
    return np.array(vector, dtype=float)[:, None]


def gravity(at, acceleration):
    return np.broadcast_to(column(acceleration), at.x.shape)


def point_gravity(at, strength, center=(0, 0, 0), softening=0.0, cutoff=0.0):
    d = at.x - column(center)
    pull = strength / (norm(d) ** 2 + softening**2) ** 1.5
    return -np.where(norm(d) < cutoff, 0.0, pull) * d


def drag(at, coefficient, flow=None):
    medium = at.u if flow else 0 * at.u
    return coefficient * (medium - at.v) * at.inverse_mass


def quadratic_drag(at, coefficient, flow=None):
    wind = (at.u if flow else 0 * at.u) - at.v
    return coefficient * norm(wind) * wind * at.inverse_mass


def vortex(at, swirl, pull=0.0, core=0.1, center=(0, 0, 0), axis=(0, 1, 0)):
    axis = np.array(axis) / np.linalg.norm(axis)
    d = at.x - column(center)
    rho = d - axis[:, None] * (axis @ d)
    around = np.cross(axis, rho.T).T
    return (swirl * around - pull * rho) / (norm(rho) ** 2 + core**2)


def orbit(at, strength, exponent=1.0, core=0.1, center=(0, 0, 0)):
    d = at.x - column(center)
    return -strength * d / (norm(d) ** 2 + core**2) ** ((exponent + 1) / 2)


def field_of_everything(at, scale):
    (x, y, z), (u, v, w) = at.x, at.v
    force = [x * v - scale * at.t, np.sin(y) * w + scale, u * z * at.t]
    return np.stack(force) * at.inverse_mass


def field_of_one_component(at, scale):
    return np.stack([0 * at.t, scale * at.x[0], 0 * at.t]) * at.inverse_mass


def field_of_potential(at, scale):
    """−∇ of scale (x² y + exp(−z²) t)."""
    x, y, z = at.x
    slope = np.stack([2 * x * y, x**2, -2 * z * np.exp(-(z**2)) * at.t])
    return -scale * slope * at.inverse_mass


@dataclass(frozen=True)
class Case:
    """A force as a scene has it, and the numbers its formula takes."""

    type: str
    reference: object
    numbers: dict
    written: dict = field(default_factory=dict)
    """The scene's keys where they are not the numbers themselves."""

    @property
    def spec(self):
        return spec(type=self.type, **(self.written or self.numbers))

    @property
    def label(self):
        """What it is, in a few words that no other case has."""
        return f"{self.reference.__name__} {self.numbers}"


CASES = [
    Case("gravity", gravity, {"acceleration": (0.4, -9.7, 1.3)}),
    Case("gravity", gravity, {"acceleration": (0, -9.7, 0)}),
    Case("point_gravity", point_gravity, {"strength": 1.7}),
    Case("point_gravity", point_gravity, {"strength": 1.7, "center": (0.3, 0, -0.4)}),
    Case("point_gravity", point_gravity, {"strength": -0.8, "center": (0.3, 0.2, -0.4), "softening": 0.6}),
    Case("point_gravity", point_gravity, {"strength": 2.3, "cutoff": 1.2}),
    Case(
        "point_gravity",
        point_gravity,
        {"strength": 2.3, "softening": 0.4, "cutoff": 1.2, "center": (0, 0.2, 0)},
    ),
    Case("drag", drag, {"coefficient": 0.37}),
    Case("drag", drag, {"coefficient": 0.37, "flow": "wind"}),
    Case("quadratic_drag", quadratic_drag, {"coefficient": 0.23}),
    Case("quadratic_drag", quadratic_drag, {"coefficient": 0.23, "flow": "wind"}),
    Case("vortex", vortex, {"swirl": 1.9}),
    Case("vortex", vortex, {"swirl": 0.0, "pull": 0.7, "core": 0.6}),
    Case(
        "vortex",
        vortex,
        {"swirl": -1.9, "pull": 0.7, "core": 0.6, "center": (0.3, -0.2, 0.4), "axis": (1, 2, -2)},
    ),
    Case("vortex", vortex, {"swirl": 1.9, "pull": -0.7, "center": (0, 0.3, 0.4), "axis": (0, 0, -1)}),
    Case("orbit", orbit, {"strength": 1.4}),
    Case("orbit", orbit, {"strength": 1.4, "exponent": 0.0, "core": 0.7, "center": (0, -0.2, 0.4)}),
    Case("orbit", orbit, {"strength": -1.4, "exponent": 2.0, "core": 0.7, "center": (0.3, -0.2, 0.4)}),
    Case("orbit", orbit, {"strength": 1.4, "exponent": 5.0, "core": 0.8}),
    Case("orbit", orbit, {"strength": 1.4, "exponent": 1.3, "core": 0.7}),
    Case(
        "force_field",
        field_of_everything,
        {"scale": 1.6},
        {"force": ["x*v - 1.6*t", "sin(y)*w + 1.6", "u*z*t"]},
    ),
    Case("force_field", field_of_one_component, {"scale": 1.6}, {"force": ["0", "1.6*x", "0"]}),
    Case("force_field", field_of_potential, {"scale": 1.6}, {"potential": "1.6*(x**2*y + exp(-z**2)*t)"}),
]
