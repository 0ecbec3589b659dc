"""Finding and lighting an isosurface, a band of rows by each worker."""

import taichi as ti

from particlecli.render.arrays import Ids, Integers, Row, Rows, vec4
from particlecli.render.binning import begin, clear_counts
from particlecli.render.liquids.density import (
    BEND,
    BLUES,
    FAR,
    NEAR,
    OWN,
    PACK,
    F,
    Single,
    climb,
    enter,
    farthest_of,
    gather,
    hidden,
    limit_of,
)
from particlecli.render.liquids.lighting import COARSE, LINES, OPAQUE, ROWS, add_thickness, light
from particlecli.render.liquids.records import EY, Y
from particlecli.render.shot import lens_in
from particlecli.render.tasks import CHUNK, WORKERS

CLIMBS = 3
"""Steps to the surface at most, before the one that lighting takes."""


@ti.func
def _take_to_bands(
    chunk, count, ranked: ti.template(), rows: ti.template(), counts: ti.template(), order: ti.template(), bands,
    placing: ti.template(),
):  # fmt: skip
    """Count a chunk's blobs by the bands that they touch, or list them where the counts say."""
    for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
        row = ti.cast(ranked[k], ti.i32)
        reach, y = rows[row, EY], rows[row, Y]
        if (reach > 0.0) & (y > -reach) & (y < bands * ROWS + reach):
            first = ti.max(ti.cast(ti.floor(y - reach), ti.i32) // ROWS, 0)
            end = ti.min(ti.cast(ti.floor(y + reach), ti.i32) // ROWS + 1, bands)
            for band in range(first, end):
                place = counts[chunk * bands + band]
                counts[chunk * bands + band] = place + 1
                if ti.static(placing):
                    order[place] = row


@ti.func
def _empty(worker, cells: ti.template(), cell, last: ti.template()):
    """Set what a pack gathers to 0, up to the last number."""
    for number in ti.static(range(F, last + 1)):
        cells[worker, cell, number] = Single(0.0)


@ti.func
def _look_again(size, packs, lines, worker, cells: ti.template(), farthest: ti.template(), again: ti.template(),
    limits: ti.template(), whole,
):  # fmt: skip
    """Empty the packs that look for blobs again, or all that have come to some, and tell how far they look."""
    for cell in range(size):
        farthest[worker, cell] = -FAR
        if whole:
            _empty(worker, cells, cell, BLUES)
        elif again[worker, cell] != 0:
            _empty(worker, cells, cell, BEND)
        if whole | (again[worker, cell] != 0):
            near = cells[worker, cell, NEAR]
            farthest[worker, cell] = farthest_of(ti.select(near < 0.5 * FAR, near, -FAR))
    for pack in range(packs):
        limits[worker, pack] = limit_of(pack, packs, lines, worker, farthest)


@ti.func
def _find(
    first, end, order: ti.template(), rows: ti.template(), top, bottom, packs, size, worker, cells: ti.template(),
    farthest: ti.template(), again: ti.template(), limits: ti.template(), level,
):  # fmt: skip
    """Climb to the surface, again where rays are in doubt, and gather what lighting takes, which is one more step."""
    for cell in range(size):
        again[worker, cell] = 1
    doubtful = 1
    for turn in range(CLIMBS + 1):
        if (doubtful != 0) | (turn == CLIMBS):
            _look_again(size, packs, bottom - top, worker, cells, farthest, again, limits, turn == CLIMBS)
            for o in range(first, end):
                if not hidden(order[o], rows, packs, worker, limits):
                    gather(order[o], rows, top, bottom, packs, worker, cells, farthest, turn == CLIMBS)
        if turn < CLIMBS:
            doubtful = 0
            for cell in range(size):
                if again[worker, cell] != 0:
                    again[worker, cell] = climb(worker, cell, cells, level, turn == CLIMBS - 1)
                    doubtful |= again[worker, cell]


@ti.func
def _enter_all(
    first, end, order: ti.template(), others: ti.template(), rows: ti.template(), top, bottom, packs, worker,
    cells: ti.template(), farthest: ti.template(), visits: ti.template(), limits: ti.template(), level, lowest,
):  # fmt: skip
    """Find where the rays of a band meet blobs; returns the end of the list of those that are not hidden."""
    for cell in range((bottom - top) * packs):
        cells[worker, cell, NEAR] = Single(FAR)
        cells[worker, cell, OWN] = Single(FAR)
        farthest[worker, cell] = FAR
        visits[worker, cell] = 0
    for pack in range(packs):
        limits[worker, pack] = FAR
    met = first
    for o in range(first, end):
        row = order[o]
        if not hidden(row, rows, packs, worker, limits):
            enter(
                row, rows, top, bottom, packs, worker, cells, farthest, visits, limits, 1.0 - level, 1.0 - lowest
            )  # fmt: skip
            others[met] = row
            met += 1
    return met


@ti.func
def _measure_thickness(
    first, end, order: ti.template(), rows: ti.template(), top, squares, worker, thick: ti.template()
):
    """How many blobs the rays of a band go through, square by square."""
    for square in range(LINES * squares):
        thick[worker, square] = 0.0
    for o in range(first, end):
        add_thickness(order[o], rows, top, squares, worker, thick)


@ti.func
def _draw_band(
    first, end, order: ti.template(), others: ti.template(), rows: ti.template(), top, bottom, width, worker,
    cells: ti.template(), farthest: ti.template(), visits: ti.template(), limits: ti.template(), thick: ti.template(),
    level, lowest, opacity_depth, metal, table: ti.template(), lens, lit: ti.template(), shape: ti.template(),
):  # fmt: skip
    """Find and light the surface of the blobs of a band; arguments as of `draw_surface`."""
    packs, squares = (width + PACK - 1) // PACK, (width + COARSE - 1) // COARSE + 2
    size = (bottom - top) * packs
    met = _enter_all(
        first, end, order, others, rows, top, bottom, packs, worker, cells, farthest, visits, limits, level, lowest
    )  # fmt: skip
    if opacity_depth < OPAQUE:
        _measure_thickness(first, end, order, rows, top, squares, worker, thick)
    _find(
        first, met, others, rows, top, bottom, packs, size, worker, cells, farthest, visits, limits, level
    )  # fmt: skip
    for cell in range(size):
        if farthest[worker, cell] > -FAR:
            y, x = top + cell // packs, cell % packs * PACK
            for at in range(ti.min(PACK, width - x)):
                if (cells[worker, cell, NEAR][at] < 0.5 * FAR) & (cells[worker, cell, F][at] > 0.0):
                    light(
                        x + at, y, top, squares, cell, at, worker, cells, thick, table, lens, level, opacity_depth,
                        metal, y * width + x + at, lit, shape,
                    )  # fmt: skip


@ti.kernel
def draw_surface(
    count: ti.i32, ranked: Ids, rows: Rows, counts: Integers, order: Integers, others: Integers, cells: ti.template(),
    farthest: ti.template(), visits: ti.template(), limits: ti.template(), thick: ti.template(), width: ti.i32,
    height: ti.i32, level: ti.f32, lowest: ti.f32, opacity_depth: ti.f32, metal: ti.f32, table: Rows, lens_row: Row,
    lit: ti.template(), shape: ti.template(), counter: Integers,
):  # fmt: skip
    """Find and light the surface of blobs, if there is room in their order.

    Args:
        ranked: rows from near to far.
        rows: see `records`.
        counts: shape ((chunks + 1) bands + 1,), see `binning`.
        order, others: rows by band, and those of them that are not hidden.
        cells, farthest, visits, limits, thick: see `Room`.
        level, lowest: τ, and 1 − q where a blob's density is too low to look for a surface there.
        opacity_depth: optical depth of one blob.
        metal: how much of a metal the liquid is.
        table: see `material`.
        lens_row: the camera.
        lit, shape: see `Room`.
    """
    chunks, bands = (count + CHUNK - 1) // CHUNK, (height + ROWS - 1) // ROWS
    ti.loop_config(block_dim=1)
    for chunk in range(chunks):
        clear_counts(chunk, bands, counts)
        _take_to_bands(chunk, count, ranked, rows, counts, order, bands, False)
    ti.loop_config(serialize=True)
    for _ in range(1):
        counter[0] = chunks if begin(chunks, bands, counts) <= order.shape[0] else 0
    ti.loop_config(block_dim=1)
    for chunk in range(counter[0]):
        _take_to_bands(chunk, count, ranked, rows, counts, order, bands, True)
    counter[0] = 0 if counts[chunks * bands + bands] <= order.shape[0] else bands
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        lens = lens_in(lens_row)
        band = ti.atomic_add(counter[0], 1)
        while band < bands:
            top, bottom = band * ROWS, ti.min(band * ROWS + ROWS, height)
            first, end = counts[chunks * bands + band], counts[chunks * bands + band + 1]
            for node in range(top * width, bottom * width):
                shape[node] = vec4(0.0, 0.0, 0.0, FAR)
            if first < end:
                _draw_band(
                    first, end, order, others, rows, top, bottom, width, worker, cells, farthest, visits, limits,
                    thick, level, lowest, opacity_depth, metal, table, lens, lit, shape,
                )  # fmt: skip
            band = ti.atomic_add(counter[0], 1)
