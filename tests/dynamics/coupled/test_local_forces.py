"""Forces between neighbours: against NumPy over all pairs, as gradients, action and reaction, and in hard cases."""

import numpy as np
import pytest

from particlecli.dynamics.coupled.lennard_jones import LennardJones
from particlecli.dynamics.coupled.rough_sphere import RoughSphere
from particlecli.dynamics.coupled.soft_sphere import SoftSphere
from particlecli.scene import forces as scene
from tests.dynamics.coupled.cloud import Cloud, accelerations, energy, summed

COUNT = 400
EDGE = 8.0
BOX = {"min": (0.0, 0.0, 0.0), "max": (EDGE, EDGE, EDGE)}
ATOMS = {
    "periodic": {"periodic": BOX},
    "potential shifted": {"shifted": "potential", "energy": 2.0, "size": 0.9},
}
GRAINS = {
    "elastic": {},
    "rough": {"damping": 3.0, "friction": 0.4},
}
RNG = np.random.default_rng(3)
POSITIONS = (
    np.stack(np.meshgrid(*[np.arange(8)] * 3), -1).reshape(-1, 3)[RNG.permutation(512)[:COUNT]] + 0.5
) * EDGE / 8 + RNG.uniform(-0.15, 0.15, (COUNT, 3))
VELOCITIES = RNG.normal(size=(COUNT, 3))
MASSES = RNG.uniform(0.5, 2.0, COUNT)


def atoms(options):
    return scene.LennardJones(type="lennard_jones", **options)


def grains(options):
    return scene.SoftSphere(type="soft_sphere", diameter=1.1, stiffness=50.0, **options)


@pytest.fixture(scope="module")
def cloud():
    return Cloud(COUNT, 30)


@pytest.fixture(scope="module")
def term(cloud):
    """Terms by specification: each compiles kernels of its own."""
    made = {}

    def of(spec):
        key = spec.model_dump_json()
        if key not in made:
            grain = RoughSphere if isinstance(spec, scene.SoftSphere) and spec.friction else SoftSphere
            kind = LennardJones if isinstance(spec, scene.LennardJones) else grain
            made[key] = kind(spec, cloud.points, (0, 1))
        return made[key]

    return of


def pairs(positions, edge=None):
    """Offsets x_i − x_j, shape (n, n, 3), and distances, infinite on the diagonal."""
    d = positions[:, None] - positions[None]
    if edge:
        d -= edge * np.round(d / edge)
    r = np.sqrt((d**2).sum(-1))
    np.fill_diagonal(r, np.inf)
    return d, r


def atom_forces(spec, positions):
    """Forces, N, and energy, J, by the textbook."""
    d, r = pairs(positions, EDGE if spec.periodic else None)
    e, s, cut = spec.energy, spec.size, spec.reach

    def value(r):
        return 4 * e * ((s / r) ** 12 - (s / r) ** 6)

    def slope(r):
        return -24 * e * (2 * (s / r) ** 12 - (s / r) ** 6) / r

    last = slope(cut) if spec.shifted == "force" else 0.0
    near = r < cut
    strength = np.where(near, last / cut - slope(r) / r, 0.0)
    energies = np.where(near, value(r) - value(cut) - last / cut * (np.where(near, r, cut) ** 2 - cut**2) / 2, 0.0)
    return (strength[..., None] * d).sum(axis=1), 0.5 * energies.sum()


def grain_forces(spec, positions, velocities):
    d, r = pairs(positions)
    n = d / r[..., None]
    v = velocities[:, None] - velocities[None]
    apart = (v * n).sum(-1)
    touches = r < spec.diameter
    pressing = np.where(touches, np.maximum(spec.stiffness * (spec.diameter - r) - spec.damping * apart, 0.0), 0.0)
    sliding = v - apart[..., None] * n
    speed = np.linalg.norm(sliding, axis=-1)
    rub = np.minimum(spec.friction * pressing, spec.damping * speed * touches) / np.where(speed > 0, speed, 1.0)
    return (pressing[..., None] * n - rub[..., None] * sliding).sum(axis=1)


@pytest.mark.parametrize("options", ATOMS.values(), ids=ATOMS)
def test_atoms_against_all_pairs(options, cloud, term):
    spec = atoms(options)
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES)
    expected, total = atom_forces(spec, POSITIONS)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    assert np.abs(forces - expected).max() < 1e-13 * np.abs(expected).max()
    assert energy(term(spec), cloud) == pytest.approx(total, rel=1e-13)


@pytest.mark.parametrize("options", GRAINS.values(), ids=GRAINS)
def test_grains_against_all_pairs(options, cloud, term):
    spec = grains(options)
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES, velocities=VELOCITIES)
    expected = grain_forces(spec, POSITIONS, VELOCITIES)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    assert np.abs(forces - expected).max() < 1e-13 * np.abs(expected).max()
    assert np.abs(expected).max() > 1.0


@pytest.mark.parametrize("number", ["energy", "size"])
def test_atoms_with_one_number_wrong_do_not_match(number, cloud, term):
    spec = atoms(next(iter(ATOMS.values())))
    wrong = spec.model_copy(update={number: 1.001 * getattr(spec, number)})
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES)
    expected, total = atom_forces(wrong, POSITIONS)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    assert np.abs(forces - expected).max() > 1e-4 * np.abs(expected).max()
    assert energy(term(spec), cloud) != pytest.approx(total, rel=1e-4)


@pytest.mark.parametrize("number", ["diameter", "stiffness", "damping", "friction"])
def test_grains_with_one_number_wrong_do_not_match(number, cloud, term):
    spec = grains(GRAINS["rough"])
    wrong = spec.model_copy(update={number: 1.001 * getattr(spec, number)})
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES, velocities=VELOCITIES)
    expected = grain_forces(wrong, POSITIONS, VELOCITIES)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    assert np.abs(forces - expected).max() > 1e-5 * np.abs(expected).max()


@pytest.mark.parametrize("spec", [*map(atoms, ATOMS.values()), *map(grains, GRAINS.values())])
def test_action_is_reaction(spec, cloud, term):
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES, velocities=VELOCITIES)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * np.abs(forces).sum()


@pytest.mark.parametrize("spec", [*map(atoms, ATOMS.values()), grains({})])
def test_forces_are_gradients(spec, cloud, term):
    h = 1e-5
    cloud.fill(POSITIONS, np.empty((0, 3)), masses=MASSES)
    forces = accelerations(term(spec), cloud) * MASSES[:, None]
    for particle, axis in ((0, 0), (17, 1), (233, 2)):
        energies = []
        for side in (-h, h):
            moved = POSITIONS.copy()
            moved[particle, axis] += side
            cloud.fill(moved, np.empty((0, 3)), masses=MASSES)
            energies.append(energy(term(spec), cloud))
        slope = (energies[1] - energies[0]) / (2 * h)
        assert forces[particle, axis] == pytest.approx(-slope, rel=1e-5, abs=1e-6)


def test_groups_act_on_each_other(cloud, term):
    spec = grains({})
    cloud.fill(POSITIONS[30:], POSITIONS[:30])
    together = accelerations(term(spec), cloud)
    cloud.fill(POSITIONS, np.empty((0, 3)))
    apart = accelerations(term(spec), cloud)
    assert np.allclose(together, np.roll(apart, -30, axis=0), rtol=1e-13, atol=1e-13)


def test_grains_at_the_same_place_do_not_act_on_each_other(cloud, term):
    for options in GRAINS.values():
        cloud.fill(np.zeros((3, 3)), np.empty((0, 3)), velocities=np.eye(3))
        assert not accelerations(term(grains(options)), cloud).any()


def test_folding_into_the_box_keeps_forces_and_lists(cloud, term):
    atoms_in_box = term(atoms(ATOMS["periodic"]))
    outside = POSITIONS + EDGE * np.random.default_rng(8).integers(-1, 2, POSITIONS.shape)
    cloud.fill(outside, np.empty((0, 3)), masses=MASSES)
    before = accelerations(atoms_in_box, cloud)
    builds = atoms_in_box.neighbors.builds
    atoms_in_box.settle()
    folded = cloud.of_slots(cloud.points.state)[:3].T
    assert np.allclose(folded, POSITIONS, rtol=0, atol=1e-13)
    atoms_in_box.prepare(0.0)
    assert np.allclose(summed(atoms_in_box, cloud), before, rtol=1e-12, atol=1e-12)
    assert atoms_in_box.neighbors.builds == builds


def test_atoms_at_the_same_place_are_not_finite(cloud, term):
    cloud.fill(np.zeros((2, 3)), np.empty((0, 3)))
    assert not np.isfinite(accelerations(term(atoms(ATOMS["potential shifted"])), cloud)).any()
    far = np.array([[k * 10.0, 0.0, 0.0] for k in range(20)])
    far[19] = far[0]
    cloud.fill(far, np.empty((0, 3)))
    assert not np.isfinite(accelerations(term(atoms(ATOMS["potential shifted"])), cloud)[[0, 19]]).any()


@pytest.mark.parametrize(
    ("kind", "spec"),
    [
        (RoughSphere, grains(GRAINS["rough"])),
        pytest.param(LennardJones, atoms(ATOMS["periodic"]), marks=pytest.mark.slow),
    ],
)
def test_results_do_not_depend_on_threads(kind, spec):
    found = []
    for threads in (1, 2, 3):
        cloud = Cloud(5_000, threads=threads)
        positions = np.random.default_rng(5).random((5_000, 3)) * 16.0
        velocities = np.random.default_rng(6).normal(size=(5_000, 3))
        cloud.fill(positions, velocities=velocities)
        found.append(accelerations(kind(spec, cloud.points, (0,)), cloud))
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])
    assert found[0].any()
