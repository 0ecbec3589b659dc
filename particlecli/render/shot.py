"""What projections need to know of the camera, of a group's paint and of a mirroring plane.

A launch costs time for each argument, and most for a structure. So these travel to kernels as rows of
numbers, one behind the other, and become structures there: `lens_row` and `lens_in`, `paint_row` and `paint_in`,
`mirror_row` and `mirror_in` list the same things in the same order.
"""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.render.arrays import vec3
from particlecli.render.camera import Doubles, View
from particlecli.render.tint import Tint
from particlecli.scene.look import PLAIN_PIXELS, GroupLook

SHORTEST = 1e-9
"""The shutter is open for at least so long, s."""

LINES = 720
"""Lines of the picture that sizes in pixels are meant for."""

Row = NDArray[np.float32]

NEAREST = 0.01
"""Particles vanish closer to the camera than this share of the distance to the point it looks at."""

Lens = ti.types.struct(
    origin=vec3,  # what to subtract from positions, m
    right=vec3,
    up=vec3,
    forward=vec3,
    center_x=ti.f32,  # pixels
    center_y=ti.f32,
    focal=ti.f32,  # pixels
    near=ti.f32,  # m
    largest=ti.f32,  # radius that no particle exceeds on the picture, pixels
    slope=ti.f32,  # a point lands focal / (slope · depth + level) pixels from the middle for each metre, see `View`
    level=ti.f32,
    blur=ti.f32,  # radius on the picture of what is out of focus, pixels m
    focus=ti.f32,  # 1 / distance in focus, 1/m
)

Paint = ti.types.struct(
    radius=ti.f32,  # m; 0 where the size is given in pixels
    pixels=ti.f32,  # 0 where the size is given in metres
    brightness=ti.f32,
    low=ti.f32,  # quantity at place 0 of the tint
    scale=ti.f32,  # places per unit of the quantity
    last=ti.f32,  # last place
    rise=ti.f32,  # 1 / share of the lifetime in which it fades in; 0: at once
    rise_start=ti.f32,  # visibility at birth: 1 where it does not fade in
    fall=ti.f32,
    fall_end=ti.f32,
    exposure=ti.f32,  # s that the shutter is open
)

Mirror = ti.types.struct(
    normal=vec3,
    height=ti.f32,  # of the camera above the plane, m
    origin=vec3,  # where the grid on the plane starts, relative to the camera, m
    along=vec3,  # axes of the grid on the plane, cells a metre long
    across=vec3,
    cells=ti.f32,  # cells a metre
    roughness=ti.f32,  # spread of mirrored light, radians
    strength=ti.f32,  # share of the light that is mirrored at grazing incidence
)


def lens_row(view: View, origin: Doubles, largest: float) -> Row:
    """The camera; `origin` is subtracted from positions (0 where they are relative to the camera already)."""
    numbers = (
        *view.center, view.focal, NEAREST * view.distance, largest, view.slope, view.level,
        0.5 * view.aperture * view.focal, 1 / view.focus,
    )  # fmt: skip
    return np.concatenate([origin, view.right, view.up, view.forward, numbers]).astype(np.float32)


PAINT, MIRROR = 21, 32
"""Where the paint and the mirror begin in a row of all three; the lens comes first."""


@ti.func
def lens_in(row: ti.template()):
    """The camera from a row."""
    return Lens(
        origin=vec3(row[0], row[1], row[2]),
        right=vec3(row[3], row[4], row[5]),
        up=vec3(row[6], row[7], row[8]),
        forward=vec3(row[9], row[10], row[11]),
        center_x=row[12],
        center_y=row[13],
        focal=row[14],
        near=row[15],
        largest=row[16],
        slope=row[17],
        level=row[18],
        blur=row[19],
        focus=row[20],
    )


def paint_row(
    *, size: tuple[float, float], brightness: float, table: tuple[float, float, float],
    fade_in: float, fade_out: float, exposure: float,
) -> Row:  # fmt: skip
    """How a group is painted.

    Args:
        size: radius in metres, and radius in pixels; one of them 0.
        brightness: light of each pixel that a particle covers.
        table: the quantity at place 0, places per unit, last place.
        fade_in, fade_out: shares of the lifetime.
        exposure: s that the shutter is open.
    """
    fading = [(1 / share, 0.0) if share > 0 else (0.0, 1.0) for share in (fade_in, fade_out)]
    return np.array([*size, brightness, *table, *fading[0], *fading[1], exposure], np.float32)


def paint_of(style: GroupLook, tint: Tint, view: View, interval: float = 0.0) -> Row:
    """The paint of a group on a view; `interval` is the time between frames, s."""
    pixels = style.pixels or (PLAIN_PIXELS if style.radius is None else 0.0)
    return paint_row(
        size=(style.radius or 0.0, pixels * view.height / LINES),
        brightness=style.brightness,
        table=(tint.low, tint.last / (tint.high - tint.low), tint.last),
        fade_in=style.fade_in,
        fade_out=style.fade_out,
        exposure=max(style.shutter * interval, SHORTEST),
    )


@ti.func
def paint_in(row: ti.template()):
    """A group's paint from a row that begins with a camera."""
    return Paint(
        radius=row[PAINT],
        pixels=row[PAINT + 1],
        brightness=row[PAINT + 2],
        low=row[PAINT + 3],
        scale=row[PAINT + 4],
        last=row[PAINT + 5],
        rise=row[PAINT + 6],
        rise_start=row[PAINT + 7],
        fall=row[PAINT + 8],
        fall_end=row[PAINT + 9],
        exposure=row[PAINT + 10],
    )


def mirror_row(
    *, normal: Doubles, height: float, origin: Doubles, along: Doubles, across: Doubles, cells: float,
    roughness: float, strength: float,
) -> Row:  # fmt: skip
    """A plane that mirrors, and the grid on it; `along` and `across` are its unit axes."""
    grid = (origin, cells * along, cells * across, [cells])
    return np.concatenate([normal, [height], *grid, [roughness, strength]]).astype(np.float32)


@ti.func
def mirror_in(row: ti.template(), first: ti.template()):
    """A mirroring plane from its row, where it begins at `first`."""
    return Mirror(
        normal=vec3(row[first], row[first + 1], row[first + 2]),
        height=row[first + 3],
        origin=vec3(row[first + 4], row[first + 5], row[first + 6]),
        along=vec3(row[first + 7], row[first + 8], row[first + 9]),
        across=vec3(row[first + 10], row[first + 11], row[first + 12]),
        cells=row[first + 13],
        roughness=row[first + 14],
        strength=row[first + 15],
    )
