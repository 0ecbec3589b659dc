"""Lists of neighbours against brute force, in crowds of every kind."""

import numpy as np
import psutil
import pytest
from scipy.spatial import cKDTree

from particlecli.dynamics.coupled.images import Map, mirror_maps, periodic_maps
from particlecli.dynamics.coupled.neighbors import SHORT, Neighbors, Periodic
from particlecli.errors import SimulationError
from particlecli.scene.planes import Plane
from tests.dynamics.coupled.cloud import Cloud

CUTOFF = 0.1
ROOM = 3000


def crowd(kind):
    """Positions, shape (n, 3), m."""
    rng = np.random.default_rng(7)
    match kind:
        case "even":
            return rng.random((ROOM, 3))
        case "sheet":
            return rng.random((ROOM, 3)) * [3.0, 0.0, 3.0]
        case "line":
            return rng.random((ROOM, 3)) * [0.0, 40.0, 0.0]
        case "lattice":
            return np.stack(np.meshgrid(*[np.arange(14)] * 3), -1).reshape(-1, 3) * CUTOFF
        case "clump and dust":
            return np.concatenate([rng.normal(0.0, 0.03, (300, 3)), rng.normal(0.0, 1e3, (2000, 3))])
        case "two clumps far apart":
            return rng.normal(0.0, 0.1, (ROOM, 3)) + 1e4 * rng.integers(0, 2, (ROOM, 1))
        case "same place":
            return np.full((100, 3), 0.25)
        case "few":
            return np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.2, 0.0]])
        case _:
            return np.zeros((1, 3))


KINDS = ("even", "sheet", "line", "lattice", "clump and dust", "two clumps far apart", "same place", "few", "alone")


@pytest.fixture(scope="module")
def cloud():
    return Cloud(ROOM, 50)


@pytest.fixture(scope="module")
def near(cloud):
    return Neighbors(cloud.points, [0], CUTOFF)


def listed(near, rows):
    """All (pack, row) pairs in the lists, and in the packs themselves."""
    count, begins, ends, entries = near.lists
    width = near.rows.width
    pairs = {(b, row) for b in range(len(ends)) for row in entries[begins[b] : ends[b]]}
    assert len(pairs) == (ends - begins).sum()
    assert not any(row // width == b and row < count for b, row in pairs)
    return pairs | {(row // width, row) for row in range(count)}


def wanted(near, at, reach):
    """All (pack, row) pairs of rows within reach."""
    width, tree = near.rows.width, cKDTree(at)
    return {(row // width, other) for row in range(near.count) for other in tree.query_ball_point(at[row], reach)}


@pytest.mark.parametrize("kind", KINDS)
def test_lists_hold_all_within_reach_and_nothing_else(kind, cloud, near):
    cloud.fill(crowd(kind), crowd("few"))
    near.forget()
    near.update()
    at = near.rows.at.to_numpy()[: near.count, :3]
    assert np.array_equal(np.sort(cloud.slots[: near.count]), np.sort(near.rows.order.to_numpy()[: near.count]))
    pairs = listed(near, at)
    assert wanted(near, at, near.reach * (1 - 1e-12)) <= pairs
    assert pairs <= wanted(near, at, near.reach * (1 + 1e-12)) | {(row // 4, row) for row in range(near.count)} | {
        (row // 4, other) for row in range(near.count) for other in range(row // 4 * 4, row // 4 * 4 + 4)
    }


def test_packs_are_small_wherever_particles_are_even(cloud, near):
    cloud.fill(crowd("even"), crowd("few"))
    near.forget()
    near.update()
    at = near.rows.at.to_numpy()[: near.count, :3].reshape(-1, 4, 3)
    fair = (4 / ROOM) ** (1 / 3)
    assert np.median(np.ptp(at, axis=1)) < 1.5 * fair


def test_lists_last_until_something_moved_by_half_the_skin(cloud, near):
    positions = crowd("even")
    cloud.fill(positions, crowd("few"))
    near.forget()
    near.update()
    builds = near.builds
    positions[17] += [0.0, 0.48 * near.skin, 0.0]
    cloud.fill(positions, crowd("few"))
    assert not near.update()
    positions[17] += [0.0, 0.03 * near.skin, 0.0]
    cloud.fill(positions, crowd("few"))
    assert near.update()
    assert near.builds == builds + 1


def test_lists_reach_further_where_particles_outrun_them(cloud, near):
    positions = crowd("even")
    cloud.fill(positions, crowd("few"))
    near.forget()
    near.update()
    before = near.skin
    for _ in range(SHORT + 1):
        assert not near.update()
    along = np.array([before, 0.0, 0.0])
    cloud.fill(positions + along, crowd("few"))
    assert near.update()
    assert near.skin == before
    cloud.fill(positions + 2.0 * along, crowd("few"))
    assert near.update()
    assert near.skin > before
    assert near.reach == CUTOFF + near.skin


def test_particles_without_mass_do_not_act(cloud, near):
    positions, masses = crowd("even"), np.ones(ROOM + 3)
    cloud.fill(positions, crowd("few"), masses=masses)
    near.forget()
    near.update()
    masses[[5, 700]] = 0.0
    cloud.fill(positions, crowd("few"), masses=masses)
    assert near.update()
    assert near.count == ROOM - 2
    assert not {5, 700} & set(near.rows.order.to_numpy()[: near.count])


def test_nobody_has_no_neighbours_until_somebody_comes(cloud):
    cloud.fill(np.empty((0, 3)), crowd("few"))
    fresh = Neighbors(cloud.points, [0], CUTOFF)
    fresh.update()
    assert fresh.count == 0
    cloud.fill(crowd("few"), crowd("few"))
    fresh.update()
    assert fresh.count == 3


def test_crowds_beyond_the_memory_are_refused_with_a_remedy(cloud, near, monkeypatch):
    monkeypatch.setattr(psutil, "virtual_memory", lambda: type("Memory", (), {"available": 1000}))
    tight = Neighbors(cloud.points, [0], CUTOFF)
    cloud.fill(crowd("same place"), crowd("few"))
    with pytest.raises(SimulationError, match=r"lists of about .* Try a smaller cutoff"):
        tight.update()


def test_a_position_that_is_not_finite_is_refused(cloud, near):
    positions = crowd("even")
    positions[3, 1] = np.nan
    cloud.fill(positions, crowd("few"))
    near.forget()
    with pytest.raises(SimulationError, match="not finite"):
        near.update()


BOX = Periodic((-1.0, 0.0, 0.5), (1.0, 2.0, 0.0))


def test_images_across_faces_complete_the_neighbourhood(cloud):
    near = Neighbors(cloud.points, [0], CUTOFF, periodic=BOX, maps=periodic_maps(BOX.size))
    positions = crowd("even") * [7.0, 5.0, 0.3] - 3.0
    cloud.fill(positions, crowd("few"))
    near.update()
    folded = np.stack([-1.0 + (positions[:, 0] + 1.0) % 1.0, positions[:, 1] % 2.0, positions[:, 2]], axis=1)
    tree = cKDTree(folded[:, :2] - [-1.0, 0.0], boxsize=[1.0, 2.0])
    order = near.rows.order.to_numpy()[: near.count]
    at = near.rows.at.to_numpy()[: near.count + len(near.images.sources), :3]
    origin = np.concatenate([order, order[near.images.sources]])
    assert np.allclose(at[: near.count], folded[order], atol=1e-12)
    around = tree.query_ball_point(folded[:, :2] - [-1.0, 0.0], CUTOFF)
    pairs = listed(near, at)
    of_pack = {}
    for b, row in pairs:
        of_pack.setdefault(b, []).append(row)
    for row in range(0, near.count, 50):
        rows = np.array(of_pack[row // 4])
        found = origin[rows[np.linalg.norm(at[rows] - at[row], axis=1) <= CUTOFF]]
        true = [j for j in around[order[row]] if np.isclose(_apart(folded[order[row]], folded[j]), 0, atol=CUTOFF)]
        assert sorted(found) == sorted(true)


def _apart(a, b):
    d = a - b
    d[0] -= np.round(d[0])
    d[1] -= 2.0 * np.round(d[1] / 2.0)
    return np.linalg.norm(d)


def test_images_behind_walls_are_mirrored_and_so_is_their_motion(cloud):
    planes = [
        Plane(point=(0.0, 0.0, 0.0), normal=(0.0, 1.0, 0.0)),
        Plane(point=(0.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0)),
    ]
    near = Neighbors(cloud.points, [0], CUTOFF, moves=True, maps=mirror_maps(planes, slips=True))
    positions = crowd("even")
    velocities = np.random.default_rng(1).normal(size=(ROOM + 3, 3))
    cloud.fill(positions, crowd("few"), velocities=velocities)
    near.update()
    order, sources = near.rows.order.to_numpy(), near.images.sources
    at, moving = near.rows.at.to_numpy()[near.count :], near.rows.moving.to_numpy()[near.count :]
    found = {
        (order[sources[i]], *np.sign(at[i, :2]).astype(int), *np.round(moving[i, :3] / velocities[order[sources[i]]]))
        for i in range(len(sources))
    }
    assert len(found) == len(sources)
    # Further away from a wall nobody is within reach of the image.
    beside, above = (positions[:, c] + positions[:, c].min() < 0.999 * near.reach for c in range(2))
    expected = {(i, 1, -1, 1.0, -1.0, 1.0) for i in np.flatnonzero(above)}
    expected |= {(i, -1, 1, -1.0, 1.0, 1.0) for i in np.flatnonzero(beside)}
    expected |= {(i, -1, -1, -1.0, -1.0, 1.0) for i in np.flatnonzero(beside & above)}
    assert expected <= found


def test_walls_that_drag_reverse_the_motion_in_every_corner():
    maps = mirror_maps([Plane(normal=(0.0, 1.0, 0.0)), Plane(normal=(1.0, 0.0, 0.0))], slips=False)
    assert len(maps) == 3
    assert all(np.array_equal(each.velocity, -np.eye(3)) for each in maps)


def test_walls_that_are_not_upright_have_no_common_images():
    maps = mirror_maps([Plane(normal=(0.0, 1.0, 0.0)), Plane(normal=(1.0, 1.0, 0.0))], slips=True)
    assert len(maps) == 2
    assert isinstance(maps[0], Map)


def test_images_beyond_the_room_get_more(cloud):
    corner = [Plane(normal=normal) for normal in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    near = Neighbors(cloud.points, [0], CUTOFF, maps=mirror_maps(corner, slips=True))
    cloud.fill(crowd("even") * 0.1, crowd("few"))
    near.update()
    assert len(near.images.sources) == 7 * ROOM
    assert near.rows.room >= 8 * ROOM
