"""Attraction by the octree: against the direct sum, as a gradient, and in crowds that trees find hard."""

import numpy as np
import pytest

from particlecli.dynamics.coupled.tree_attraction import TreeAttraction
from particlecli.scene import forces as scene
from tests.cases import later
from tests.dynamics.coupled.cloud import LANES, Cloud

ROOM = 3000
RNG = np.random.default_rng(4)
MASSES = RNG.uniform(0.5, 2.0, ROOM)


def crowd(kind):
    """Positions, m, shape (n, 3)."""
    rng = np.random.default_rng(9)
    match kind:
        case "galaxy":
            towards = rng.normal(size=(ROOM, 3))
            radius = 1.0 / np.sqrt(rng.uniform(0.05, 0.99, ROOM) ** (-2 / 3) - 1.0)
            return towards * (radius / np.linalg.norm(towards, axis=1))[:, None]
        case "even":
            return rng.random((ROOM, 3))
        case "sheet":
            return rng.random((ROOM, 3)) * [1.0, 1.0, 0.0]
        case "clumps":
            return rng.normal(0.0, 1e-9, (ROOM, 3)) + 1e3 * rng.integers(0, 3, (ROOM, 1))
        case "pairs":
            return np.repeat(rng.random((ROOM // 2, 3)), 2, axis=0)
        case "same place":
            return np.ones((100, 3))
        case _:
            return np.array([[0.5, 0.0, 0.0]])


def by_plain_sum(x, mass, softening):
    """Accelerations, shape (n, 3), and the potential energy, as `Attraction` defines them; G = 1."""
    total, energy = np.zeros_like(x), 0.0
    for i in range(len(x)):
        d = x - x[i]
        r2 = (d**2).sum(axis=1)
        inverse = np.zeros(len(x))
        apart = r2 > 0
        inverse[apart] = (r2[apart] + softening**2) ** -0.5
        total[i] = (mass * inverse**3) @ d
        energy -= 0.5 * mass[i] * (mass @ inverse)
    return total, energy


@pytest.fixture(scope="module")
def cloud():
    return Cloud(ROOM)


@pytest.fixture(scope="module", params=[0.0, 0.05], ids=["hard", "soft"])
def term(request, cloud):
    spec = scene.Attraction(type="attraction", strength=1.0, softening=request.param, opening_angle=0.5)
    return TreeAttraction(spec, cloud.points, (0,))


def found(term, cloud):
    cloud.points.memory.open()
    term.prepare(0.0)
    return cloud.of_slots(term.accelerations).T


@pytest.mark.parametrize("kind", ["galaxy", "clumps", "same place", "alone", *later("even", "sheet", "pairs")])
def test_forces_are_those_of_all_pairs_within_a_thousandth(kind, term, cloud):
    x = crowd(kind)
    mass = MASSES[: len(x)]
    cloud.fill(x, masses=mass)
    exact, energy = by_plain_sum(x, mass, term.spec.softening)
    error = np.linalg.norm(found(term, cloud) - exact, axis=1)
    assert np.sqrt((error**2).mean()) <= 1e-3 * np.sqrt((exact**2).sum(axis=1).mean())
    if kind in ("galaxy", "even", "sheet"):
        size = np.linalg.norm(exact, axis=1)
        assert np.median(error / size) < 1e-3
        term.prepare_potential(0.0)
        own = cloud.of_slots(term.potentials)
        assert 0.5 * mass @ own == pytest.approx(energy, rel=1e-4)


def test_a_sum_with_one_number_wrong_is_further_off(term, cloud):
    x = crowd("galaxy")
    cloud.fill(x, masses=MASSES)
    forces = found(term, cloud)
    right, softer = (by_plain_sum(x, MASSES, term.spec.softening + more)[0] for more in (0.0, 0.03))
    for wrong in (-right, 1.01 * right, softer):
        error = np.linalg.norm(forces - wrong, axis=1)
        assert np.sqrt((error**2).mean()) > 3e-3 * np.sqrt((wrong**2).sum(axis=1).mean())


def test_cells_hold_their_bodies_once_and_know_their_moments(term, cloud):
    x = crowd("galaxy")
    cloud.fill(x, masses=MASSES)
    found(term, cloud)
    tree = term.tree
    bodies = tree.bodies.to_numpy()[: tree.count]
    span = tree.cells.span.to_numpy()[: tree.cell_count]
    center, spread = (field.to_numpy()[: tree.cell_count] for field in (tree.cells.center, tree.cells.spread))
    leaves = span[span[:, 3] == 1]
    assert np.array_equal(leaves[:, 0], np.r_[0, leaves[:-1, 1]])
    assert leaves[-1, 1] == ROOM
    assert (leaves[:, 1] - leaves[:, 0]).max() <= 16
    assert np.array_equal(np.sort(tree.order.to_numpy()[:ROOM]), cloud.slots)
    for n in range(0, tree.cell_count, 37):
        inside = bodies[span[n, 0] : span[n, 1]]
        mass = inside[:, 3]
        middle = mass @ inside[:, :3] / mass.sum()
        d = inside[:, :3] - middle
        assert center[n] == pytest.approx([*middle, mass.sum()], rel=1e-12)
        second = np.einsum("n,ni,nj->ij", mass, d, d)[np.triu_indices(3)]
        assert spread[n] == pytest.approx(second, rel=1e-9, abs=1e-12 * np.abs(second).max() + 1e-20)


def test_a_smaller_angle_is_more_accurate(cloud):
    x = crowd("galaxy")
    cloud.fill(x, masses=MASSES)
    exact, _ = by_plain_sum(x, MASSES, 0.0)
    errors = []
    spec = scene.Attraction(type="attraction", strength=1.0)
    fine = TreeAttraction(spec, cloud.points, (0,))
    for angle in (0.8, 0.4, 0.2):
        fine.tree.angle = angle
        error = np.linalg.norm(found(fine, cloud) - exact, axis=1) / np.linalg.norm(exact, axis=1)
        errors.append(np.sqrt((error**2).mean()))
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_bodies_without_mass_do_not_attract(term, cloud):
    x, masses = crowd("even"), MASSES.copy()
    masses[100:] = 0.0
    cloud.fill(x, masses=masses)
    exact, _ = by_plain_sum(x[:100], MASSES[:100], term.spec.softening)
    assert found(term, cloud)[:100] == pytest.approx(exact, rel=5e-3, abs=1e-2 * np.abs(exact).max())


def test_auto_takes_the_tree_for_many():
    spec = scene.Attraction(type="attraction")
    assert not spec.uses_tree(1000)
    assert spec.uses_tree(1_000_000)
    assert scene.Attraction(type="attraction", method="tree").uses_tree(10)
    assert not scene.Attraction(type="attraction", method="direct").uses_tree(1_000_000)


def test_results_do_not_depend_on_threads():
    results = {}
    for threads in (1, 3):
        cloud = Cloud(ROOM, threads=threads)
        cloud.fill(crowd("galaxy"), masses=MASSES)
        results[threads] = found(TreeAttraction(scene.Attraction(type="attraction"), cloud.points, (0,)), cloud)
        assert len(cloud.slots) % LANES != 0
    assert np.array_equal(results[1], results[3])
