"""Symmetric 3×3 matrices xx, xy, xz, yy, yz, zz, one for each particle of a pack; and sums over a pack."""

import taichi as ti


@ti.func
def product(blocks: ti.template(), b, vectors: ti.template()):
    """Symmetric 3×3 matrices xx, xy, xz, yy, yz, zz times vectors, of pack b."""
    return multiplied([blocks[c, b] for c in ti.static(range(6))], [vectors[c, b] for c in ti.static(range(3))])


@ti.func
def multiplied(block, vector):
    """A symmetric 3×3 matrix xx, xy, xz, yy, yz, zz times a vector."""
    xx, xy, xz, yy, yz, zz = block[0], block[1], block[2], block[3], block[4], block[5]
    x, y, z = vector[0], vector[1], vector[2]
    return [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]


@ti.func
def inverted(block):
    """The inverse of such a matrix; of one that rounding has made singular, that of its trace; zero of zero."""
    xx, xy, xz, yy, yz, zz = block[0], block[1], block[2], block[3], block[4], block[5]
    det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    share, trace = ti.select(det > 0.0, 1.0 / det, 0.0), xx + yy + zz
    rest = ti.select((det > 0.0) | (trace <= 0.0), 0.0, 1.0 / trace)
    return [
        (yy * zz - yz * yz) * share + rest,
        (xz * yz - xy * zz) * share,
        (xy * yz - xz * yy) * share,
        (xx * zz - xz * xz) * share + rest,
        (xy * xz - xx * yz) * share,
        (xx * yy - xy * xy) * share + rest,
    ]


@ti.func
def total(packs: ti.template(), row: ti.template(), i):
    """The sum of the 16 lanes of a pack of a field, halves added to each other.

    Of a field: of a variable that lanes are taken of LLVM computes each lane by itself, from the beginning.
    """
    eight = [packs[row, i][lane] + packs[row, i][lane + 8] for lane in ti.static(range(8))]
    four = [eight[lane] + eight[lane + 4] for lane in ti.static(range(4))]
    return (four[0] + four[2]) + (four[1] + four[3])
