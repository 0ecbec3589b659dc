"""From particles to sprites: where each lands in the picture, how large, how bright, in which colour.

A sprite is light spread over a round spot: its place (pixels), its radius, its energy (the sum of all pixel
values it adds, for a tint of 1) and its place in the tint's table; smeared sprites also have a tail, the
vector back to where they were when the shutter opened. Particles that are not seen get energy 0.

Functions take one particle by its number, or PACK of them by a list of their numbers; a place or a direction is then a
list of packs.
"""

import math

import taichi as ti

from particlecli.render.arrays import Row, Rows, vec3
from particlecli.render.particles import GIVEN, LIFE_SHARE, SPEED
from particlecli.render.shot import lens_in, paint_in
from particlecli.render.sprites import ENERGY, PACK, RADIUS, SEEN, TAIL_X, TAIL_Y, TINT, X, Y
from particlecli.render.tasks import CHUNK

_SINGLE = ti.types.vector(PACK, ti.f32)


@ti.func
def smooth(t):
    """0 up to t = 0, 1 from t = 1 on, without a kink."""
    s = ti.min(ti.max(t, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@ti.func
def taken(row: ti.template(), i):
    """A particle's number in a row, or a pack of them."""
    if ti.static(isinstance(i, list)):
        return _SINGLE([row[k] for k in i])
    return row[i]


@ti.func
def vector(rows: ti.template(), i):
    """A vector of three rows."""
    if ti.static(isinstance(i, list)):
        return [_SINGLE([rows[c, k] for k in i]) for c in ti.static(range(3))]
    return vec3(rows[0, i], rows[1, i], rows[2, i])


@ti.func
def _bound(value):
    return value


@ti.func
def _offset(point, origin):
    return [_bound(point[c] - origin[c]) for c in ti.static(range(3))]


@ti.func
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@ti.func
def _alike(number, i):
    """A number for each particle."""
    if ti.static(isinstance(i, list)):
        return _SINGLE(number)
    return number


@ti.func
def table_place(
    i, velocities: ti.template(), quantity: ti.template(), ages: ti.template(), lifetimes: ti.template(),
    paint, source,
):  # fmt: skip
    """Place of a particle in the tint's table, between the first and the last."""
    value = _alike(paint.low, i)
    if source == GIVEN:
        value = taken(quantity, i)
    elif source == LIFE_SHARE:
        value = taken(ages, i) / taken(lifetimes, i)
    elif source == SPEED:
        velocity = vector(velocities, i)
        value = ti.sqrt(dot(velocity, velocity))
    return ti.min(ti.max((value - paint.low) * paint.scale, 0.0), paint.last)


@ti.func
def radiance(i, ages: ti.template(), lifetimes: ti.template(), paint, fading):
    """Light of each pixel that a particle covers, for a tint of 1."""
    light = _alike(paint.brightness, i)
    if fading:
        share = taken(ages, i) / taken(lifetimes, i)
        rise = smooth(share * paint.rise + paint.rise_start)
        light = light * rise * smooth((1.0 - share) * paint.fall + paint.fall_end)
    return light


@ti.func
def above(height, radius):
    """Share of a particle that is seen over a plane: all while its middle is above, none a diameter below."""
    return smooth(1.0 + height / (2.0 * radius))


@ti.func
def height_over(plane, planes: ti.template(), point):
    """Height above a plane (normal, height of the camera above it) of a point relative to the camera, m."""
    return planes[plane, 3] + dot([planes[plane, 0], planes[plane, 1], planes[plane, 2]], point)


@ti.func
def seen_over_planes(light, point, radius, planes: ti.template(), occluders):
    """What is left of a particle's light where the first `occluders` planes hide what is behind them.

    Its place is relative to the camera, and its radius in m.
    """
    left = light
    for p in range(occluders):
        left = left * above(height_over(p, planes, point), radius)
    return left


@ti.func
def scale_at(depth, lens):
    """Pixels a metre at a depth."""
    return lens.focal / ti.max(lens.slope * depth + lens.level, lens.near)


@ti.func
def blurred(radius, depth, lens):
    """Radius in pixels of a particle that the lens blurs: variances add up, R² = r² + c².

    The radius of the blur of a thin lens is c = ½ aperture · focal · |1/focus − 1/depth|.
    """
    blur = lens.blur * (lens.focus - 1.0 / ti.max(depth, lens.near))
    return ti.sqrt(radius * radius + blur * blur)


@ti.func
def on_picture(point, lens):
    """Place in pixels, pixels a metre there, and how much of the light comes past the near limit."""
    depth = dot(point, lens.forward)
    scale = scale_at(depth, lens)
    across, up = dot(point, lens.right) * scale, dot(point, lens.up) * scale
    return [lens.center_x + across, lens.center_y - up], scale, smooth(depth / lens.near - 1.0)


@ti.func
def touches_picture(place, wide, high, lens):
    """Whether what reaches so many pixels to each side of its place, and up and down, touches the picture."""
    across, down = ti.abs(place[0] - lens.center_x), ti.abs(place[1] - lens.center_y)
    return (across < lens.center_x + wide) & (down < lens.center_y + high)


@ti.func
def exposed(i, ages: ti.template(), paint, aged):
    """For how long a particle was seen while the shutter was open, and the share of the exposure that is."""
    seconds = _alike(paint.exposure, i)
    if aged:
        seconds = ti.min(seconds, taken(ages, i))
    return seconds, seconds / paint.exposure


@ti.func
def start_of_path(point, velocity, seconds, lens):
    """Where a particle was `seconds` ago, in pixels; if behind the camera, where it passed the near limit."""
    way = [velocity[c] * seconds for c in ti.static(range(3))]
    depth, depth_before = dot(point, lens.forward), dot(point, lens.forward) - dot(way, lens.forward)
    passed = (depth_before < lens.near) & (depth > lens.near)
    share = ti.select(passed, (depth - lens.near) / (depth - depth_before), 1.0)
    place, _, _ = on_picture([point[c] - way[c] * share for c in ti.static(range(3))], lens)
    return place


@ti.func
def put(sprites: ti.template(), which, k, place, radius, energy, tint):
    """Set a sprite of a set, but for its tail."""
    b, lane = k // PACK, k % PACK
    sprites[which, X, b][lane] = place[0]
    sprites[which, Y, b][lane] = place[1]
    sprites[which, RADIUS, b][lane] = radius
    sprites[which, ENERGY, b][lane] = energy
    sprites[which, TINT, b][lane] = tint


@ti.func
def put_tail(sprites: ti.template(), which, k, tail):
    """Set a sprite's tail."""
    sprites[which, TAIL_X, k // PACK][k % PACK] = tail[0]
    sprites[which, TAIL_Y, k // PACK][k % PACK] = tail[1]


@ti.kernel
def project(
    first: ti.i32, count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row,
    shot: Row, planes: Rows, sprites: ti.template(),
    at: ti.i32, source: ti.i32, fading: ti.i32, aged: ti.i32, smeared: ti.i32, occluders: ti.i32, alone: ti.template(),
):  # fmt: skip
    """Sprites of `count` particles from the `first` on, as the camera sees them; `shot` has its lens and their paint.

    They come to the places from `at` on, a multiple of PACK, of the set SEEN; one thread does it `alone`.

    Energy is π radius² × radiance. Particles behind one of the `occluders` planes (normal, height of the
    camera above it) are hidden. Idle lanes of the last pack repeat the last particle.
    """
    if ti.static(alone):
        ti.loop_config(serialize=True)
    else:
        ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        lens, paint = lens_in(shot), paint_in(shot)
        end = ti.min(count, chunk * CHUNK + CHUNK)
        for b in range(chunk * CHUNK // PACK, (end + PACK - 1) // PACK):
            s = at // PACK + b
            i = [_bound(first + ti.min(b * PACK + k, count - 1)) for k in ti.static(range(PACK))]
            point = _offset(vector(positions, i), lens.origin)
            place, scale, light = on_picture(point, lens)
            radius = ti.min(paint.radius * scale + paint.pixels, lens.largest)
            light = seen_over_planes(light, point, radius / scale, planes, occluders)
            light = light * radiance(i, ages, lifetimes, paint, fading)
            if smeared:
                seconds, share = exposed(i, ages, paint, aged)
                light = light * share
                start = start_of_path(point, vector(velocities, i), seconds, lens)
                sprites[SEEN, TAIL_X, s] = start[0] - place[0]
                sprites[SEEN, TAIL_Y, s] = start[1] - place[1]
            sprites[SEEN, X, s] = place[0]
            sprites[SEEN, Y, s] = place[1]
            sprites[SEEN, RADIUS, s] = ti.min(blurred(radius, dot(point, lens.forward), lens), lens.largest)
            sprites[SEEN, ENERGY, s] = light * (math.pi * radius * radius)
            sprites[SEEN, TINT, s] = table_place(i, velocities, quantity, ages, lifetimes, paint, source)
