"""Fluid: against NumPy over all pairs, as the gradient of its energy, and what it must conserve and hold."""

import numpy as np
import pytest

from particlecli import simulate
from particlecli.dynamics.coupled.smoothing import CubicSpline, Wendland
from particlecli.dynamics.coupled.sph import Sph
from particlecli.errors import SimulationError
from particlecli.scene import forces as scene
from particlecli.scene.planes import Plane
from tests.dynamics.coupled.cloud import Cloud, accelerations, energy, summed
from tests.dynamics.scenes import scene as scene_of

ROOM = 500
H = 0.13
FLOOR = (Plane(normal=(0.0, 1.0, 0.0)), Plane(normal=(1.0, 0.0, 0.0)))
FLUIDS = {
    "artificial": {"viscosity": {"artificial": 0.3}},
    "laminar": {"viscosity": {"laminar": 0.4}, "kernel": "cubic_spline", "exponent": 1, "tension": True},
    "in a plane": {"viscosity": {"artificial": 0.0}, "dimensions": 2, "density_by": "summation", "tension": True},
}
EXACT = 1e-11
NUMBERS = ("density", "sound_speed", "exponent")
RNG = np.random.default_rng(11)
SPACE = (np.stack(np.meshgrid(*[np.arange(7)] * 3), -1).reshape(-1, 3) + 0.5) * 0.1 + RNG.uniform(-0.02, 0.02, (343, 3))
SHEET = np.stack(np.meshgrid(np.arange(20) + 0.5, np.arange(17) + 0.5, [0.0]), -1).reshape(-1, 3) * 0.1
SHEET = SHEET + RNG.uniform(-0.02, 0.02, SHEET.shape) * [1.0, 1.0, 0.0]


def fluid(options):
    return scene.Sph(type="sph", density=1000.0, smoothing=H, sound_speed=20.0, **options)


def place(options):
    positions = SHEET if options.get("dimensions") == 2 else SPACE
    flat = [1.0, 1.0, 0.0] if options.get("dimensions") == 2 else 1.0
    return positions, np.random.default_rng(2).normal(size=positions.shape) * flat


@pytest.fixture(scope="module")
def cloud():
    return Cloud(ROOM)


@pytest.fixture(scope="module")
def term(cloud):
    """Terms by specification and walls: each compiles kernels of its own."""
    made = {}

    def of(options, walls=()):
        spec = fluid(options)
        key = (spec.model_dump_json(), len(walls))
        if key not in made:
            made[key] = Sph(spec, cloud.points, (0,), walls)
        return made[key]

    return of


def bell(spec, r):
    """W and W′/r by the textbook."""
    q, d = r / H, spec.dimensions
    if spec.kernel == "wendland":
        height = {2: 7 / (4 * np.pi), 3: 21 / (16 * np.pi)}[d] / H**d
        s = np.where(q < 2, 1 - q / 2, 0)
        return height * s**4 * (1 + 2 * q), -5 * height / H**2 * s**3
    height = {2: 10 / (7 * np.pi), 3: 1 / np.pi}[d] / H**d
    value = np.where(q < 1, 1 - 1.5 * q**2 + 0.75 * q**3, np.where(q < 2, 0.25 * (2 - q) ** 3, 0))
    slope = np.where(q < 1, -3 * q + 2.25 * q**2, np.where(q < 2, -0.75 * (2 - q) ** 2, 0))
    return height * value, height * slope / (H**2 * np.where(q > 0, q, 1))


def pairwise(spec, positions, velocities, mass, sums_at_rest):
    d, v = positions[:, None] - positions[None], velocities[:, None] - velocities[None]
    r2 = (d**2).sum(-1)
    value, slope = bell(spec, np.sqrt(r2))
    density = mass * value.sum(axis=1)
    if spec.density_by == "continuity":
        density = density + spec.density - sums_at_rest
    ratio = density / spec.density
    if not spec.tension:
        ratio = np.maximum(ratio, 1.0)
    pressure = spec.density * spec.sound_speed**2 / spec.exponent * (ratio**spec.exponent - 1)
    stress = pressure / (spec.density * ratio) ** 2
    total = (stress[:, None] + stress[None])[..., None] * d
    closing = (d * v).sum(-1)
    if isinstance(spec.viscosity, type(fluid(FLUIDS["laminar"]).viscosity)):
        drag = 2 * spec.viscosity.laminar / spec.density * r2 / (r2 + 0.01 * H**2)
        total = total - drag[..., None] * v
    else:
        push = -spec.viscosity.artificial * spec.sound_speed * H * np.minimum(closing, 0) / (r2 + 0.01 * H**2)
        total = total + (push / spec.density)[..., None] * d
    return -mass * (slope[..., None] * total).sum(axis=1)


def measured(options, cloud, term):
    """Accelerations of a fluid that has been squeezed, and a function that tells those of another by the textbook."""
    positions, velocities = place(options)
    spec = fluid(options)
    mass = 1000.0 * 0.1**spec.dimensions
    cloud.fill(positions, masses=mass, velocities=velocities)
    accelerations(term(options), cloud)
    at_rest = mass * bell(spec, np.linalg.norm(positions[:, None] - positions[None], axis=-1))[0].sum(axis=1)
    squeezed = positions * [0.97, 0.99, 1.0]
    cloud.fill(squeezed, masses=mass, velocities=velocities)
    term(options).prepare(0.0)
    found = summed(term(options), cloud)
    return found, lambda other: pairwise(other, squeezed, velocities, mass, at_rest)


@pytest.mark.parametrize("options", FLUIDS.values(), ids=FLUIDS)
def test_against_all_pairs(options, cloud, term):
    found, textbook = measured(options, cloud, term)
    expected = textbook(fluid(options))
    assert np.abs(found - expected).max() < EXACT * np.abs(expected).max()
    assert np.abs(found.sum(axis=0)).max() < 1e-13 * np.abs(found).sum()


@pytest.mark.parametrize("options", FLUIDS.values(), ids=FLUIDS)
def test_a_formula_with_one_number_wrong_does_not_match(options, cloud, term):
    found, textbook = measured(options, cloud, term)
    spec = fluid(options)
    wrong = {number: spec.model_copy(update={number: 1.001 * getattr(spec, number)}) for number in NUMBERS}
    ((kind, viscosity),) = options["viscosity"].items()
    wrong[kind] = fluid({**options, "viscosity": {kind: 1.001 * viscosity or 0.01}})
    for number, other in wrong.items():
        expected = textbook(other)
        assert np.abs(found - expected).max() > 1e4 * EXACT * np.abs(expected).max(), number


@pytest.mark.parametrize(
    "walls", [pytest.param((), id="free", marks=pytest.mark.slow), pytest.param(FLOOR, id="walls")]
)
@pytest.mark.parametrize("options", [{"viscosity": {"artificial": 0.0}}, FLUIDS["in a plane"]], ids=["space", "plane"])
def test_forces_are_gradients(options, walls, cloud, term):
    positions, _ = place(options)
    mass = 1000.0 * 0.1 ** fluid(options).dimensions
    cloud.fill(positions, masses=mass)
    it = term(options, walls)
    accelerations(it, cloud)
    squeezed = positions * 0.98
    cloud.fill(squeezed, masses=mass)
    it.prepare(0.0)
    forces = summed(it, cloud) * mass
    for particle, axis in ((0, 0), (40, 1), (101, 0)):
        energies = []
        for h in (-1e-6, 1e-6):
            moved = squeezed.copy()
            moved[particle, axis] += h
            cloud.fill(moved, masses=mass)
            it.prepare_potential(0.0)
            energies.append(cloud.of_slots(it.energies).sum())
        assert forces[particle, axis] == pytest.approx(-(energies[1] - energies[0]) / 2e-6, rel=1e-4, abs=1e-3)


def test_fluid_at_rest_density_is_at_rest(cloud, term):
    cloud.fill(SPACE, masses=1.0)
    assert not accelerations(term(FLUIDS["artificial"]), cloud).any()
    assert energy(term(FLUIDS["artificial"]), cloud) == 0.0


def test_density_and_pressure_are_told(cloud, term):
    it = term(FLUIDS["in a plane"])
    positions, _ = place(FLUIDS["in a plane"])
    cloud.fill(positions, masses=10.0)
    it.rearranged()
    density, pressure = it.fluid()
    expected = 10.0 * bell(it.spec, np.linalg.norm(positions[:, None] - positions[None], axis=-1))[0].sum(axis=1)
    assert density[cloud.slots] == pytest.approx(expected)
    assert pressure[cloud.slots] == pytest.approx(1000.0 * 20.0**2 / 7 * ((expected / 1000.0) ** 7 - 1))


def test_a_sheet_must_be_flat(cloud, term):
    it = term(FLUIDS["in a plane"])
    cloud.fill(SHEET + np.array([0.0, 0.0, 5.0]), masses=10.0)
    raised = accelerations(it, cloud)
    cloud.fill(SHEET, masses=10.0)
    assert raised == pytest.approx(accelerations(it, cloud))
    cloud.fill(SHEET + np.where(np.arange(len(SHEET)) == 7, 0.01, 0.0)[:, None] * [0.0, 0.0, 1.0], masses=10.0)
    it.rearranged()
    with pytest.raises(SimulationError, match="in one plane z = constant"):
        it.prepare(0.0)


def test_all_in_one_place_have_the_density_that_belongs_to_it(cloud, term):
    it = term(FLUIDS["in a plane"])
    cloud.fill(np.full((ROOM, 3), 0.25), masses=1e-3)
    assert not accelerations(it, cloud).any()
    assert it.fluid()[0][cloud.slots] == pytest.approx(ROOM * 1e-3 * bell(it.spec, np.zeros(1))[0][0])


def test_particles_at_the_same_place_do_not_push_each_other(cloud, term):
    cloud.fill(np.zeros((2, 3)), masses=1000.0)
    assert not accelerations(term({**FLUIDS["in a plane"]}), cloud).any()


def ball(*center):
    x, y, z = center
    inside = f"(x - {x})**2 + (y - {y})**2 + (z - {z})**2 < 0.2"
    return {"type": "lattice", "center": center, "size": [1, 1, 1], "spacing": 0.1, "where": inside}


def splash(threads):
    """Two drops collide beside a wall: momenta along y and z, at the beginning and the end, and the last frame."""
    drops = {
        "low": {"layout": ball(0.7, 0.0, 0.0), "velocity": [-1, 2, 0], "mass": 1},
        "high": {"layout": ball(0.7, 1.1, 0.1), "velocity": ["y - 3", -2, "sin(9*y)"], "mass": 1},
    }
    fluid = {"type": "sph", "density": 1000, "smoothing": 0.13, "sound_speed": 20}
    parts = {"particles": drops, "forces": [fluid], "planes": [{"normal": [1, 0, 0]}], "fps": 10, "duration": 0.3}
    first, *_, last = simulate(
        scene_of(**parts, integrator={"type": "symplectic_euler", "dt": 5e-4}, precision="double"), threads=threads
    )
    momenta = [sum(group.velocities.sum(axis=0) for group in frame.groups.values()) for frame in (first, last)]
    return momenta[0][1:], momenta[1][1:], last


@pytest.mark.slow
def test_a_long_run_keeps_momentum_to_roundoff_and_its_bits_on_any_number_of_threads():
    before, after, last = splash(threads=1)
    speed = sum(np.abs(group.velocities).sum() for group in last.groups.values())
    assert np.abs(after - before).max() < 1e-13 * speed
    assert np.abs(before).max() > 1
    for threads in (2, 3):
        for name, group in splash(threads)[2].groups.items():
            np.testing.assert_array_equal(group.positions, last.groups[name].positions)
            np.testing.assert_array_equal(group.velocities, last.groups[name].velocities)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("kind", [Wendland, CubicSpline])
def test_kernels_integrate_to_one(kind, dimensions):
    r = np.linspace(0.0, 2.0 * H, 20_001)
    kernel = "wendland" if kind is Wendland else "cubic_spline"
    value = bell(fluid({"dimensions": dimensions, "kernel": kernel}), r)[0]
    shell = 2 * np.pi * r if dimensions == 2 else 4 * np.pi * r**2
    assert np.trapezoid(value * shell, r) == pytest.approx(1.0, rel=1e-6)
    assert value[0] == pytest.approx(kind(H, dimensions).height)
