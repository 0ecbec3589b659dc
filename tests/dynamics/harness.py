"""Evaluates functions and terms on arrays of points, in kernels that work on packs as the engine's do."""

from dataclasses import dataclass, fields

import numpy as np
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.flows import flow_term
from particlecli.dynamics.forces import force_term
from particlecli.dynamics.memory import FieldMemory

LANES = 16
EPSILON = {"single": 2.0**-24, "double": 2.0**-53}
"""Largest relative error of one rounding."""


def numpy_type(precision):
    return np.float64 if precision == "double" else np.float32


def rounded(values, precision):
    """The numbers as the kernels see them, in double."""
    return np.asarray(values).astype(numpy_type(precision)).astype(np.float64)


def on_packs(precision, function, *columns, outputs=1, parameters=(), name=None, one_by_one=False):
    """What a function of packs returns at many points.

    Args:
        function: called while the kernel is traced with the parameters and one pack for each column; returns
            as many components as `outputs`, each a pack, a scalar or a Python number.
        columns: arrays of n numbers.
        parameters: numbers for the kernel, given to the function as a list of scalars.
        name: a later call with the same name uses the same kernel again.
        one_by_one: the function gets scalars instead, which compiles much faster.

    Returns:
        Shape (outputs, n).
    """
    runtime.start(precision, 1)
    dtype = ti.f64 if precision == "double" else ti.f32
    count = len(columns[0])
    blocks = -(-count // LANES)
    views = _fields(dtype, blocks, outputs + len(columns))
    results, inputs = ([view.field for view in part] for part in (views[:outputs], views[outputs:]))
    numbers = _numbers(dtype, parameters)
    for column, view in zip(columns, views[outputs:], strict=True):
        view.array[:] = np.resize(column, blocks * LANES).reshape(blocks, LANES)

    @ti.kernel
    def run():
        for block in range(blocks):
            p = [numbers[i] for i in ti.static(range(len(parameters)))]
            packs = [inputs[i][block] for i in ti.static(range(len(columns)))]
            found = ti.static(tuple(function(p, *packs)))
            for i in ti.static(range(outputs)):
                # The sum with zeros makes a pack of whatever it is.
                results[i][block] = ti.Vector([0.0] * LANES) + found[i]

    @ti.kernel
    def run_one_by_one():
        for point in range(blocks * LANES):
            block, lane = point // LANES, point % LANES
            p = [numbers[i] for i in ti.static(range(len(parameters)))]
            scalars = [inputs[i][block][lane] for i in ti.static(range(len(columns)))]
            found = ti.static(tuple(function(p, *scalars)))
            for i in ti.static(range(outputs)):
                results[i][block][lane] = found[i]

    kernels = _kept((name, blocks, one_by_one))
    if name is None or not kernels:
        kernels.append(run_one_by_one if one_by_one else run)
    kernels[-1]()
    return np.stack([view.array.reshape(-1)[:count].astype(np.float64) for view in views[:outputs]])


_pool = {}
"""Fields, used again by later calls: every new one would slow Taichi down."""


def _kept(name):
    program = ti.lang.impl.get_runtime().prog
    if _pool.get("program") is not program:
        _pool.clear()
        _pool["program"] = program
    return _pool.setdefault(name, [])


def _fields(dtype, blocks, count):
    kept, memory = _kept(blocks), FieldMemory()
    while len(kept) < count:
        kept.append(memory.view(ti.field(ti.types.vector(LANES, dtype), shape=blocks)))
    return kept[:count]


def _numbers(dtype, values):
    kept = _kept("numbers")
    if not kept:
        kept.append(FieldMemory().view(ti.field(dtype, shape=16)))
    kept[0].array[:] = np.resize([*values, 0.0], 16)
    return kept[0].field


def placed_flow_term(precision, spec, scene_seed):
    """A flow term with its table in place."""
    runtime.start(precision, 1)
    term = flow_term(spec, scene_seed)
    if term.table is not None:
        kept = _kept(term.table.shape)
        if not kept:
            real = ti.f64 if precision == "double" else ti.f32
            kept.append(FieldMemory().view(ti.field(real, shape=term.table.shape)))
        term.rows = kept[0].field
        kept[0].array[:] = term.table
    return term


def velocity(precision, spec, x, t, scene_seed=0):
    """Velocity of a flow term at points of shape (3, n) and times of shape (n,): shape (3, n)."""
    term = placed_flow_term(precision, spec, scene_seed)

    def components(p, *packs):
        return term.velocity(p, packs[:3], packs[3])

    name = ("velocity", spec, scene_seed)
    return on_packs(precision, components, *x, t, outputs=3, parameters=term.parameters(), name=name)


@dataclass(frozen=True)
class Points:
    """Where a force is evaluated: x, v and the flow velocity u of shape (3, n), t and 1/m of shape (n,)."""

    x: np.ndarray
    v: np.ndarray
    u: np.ndarray
    t: np.ndarray
    inverse_mass: np.ndarray

    def columns(self):
        return [*self.x, *self.v, *self.u, self.t, self.inverse_mass]

    def rounded(self, precision):
        return Points(*(rounded(getattr(self, field.name), precision) for field in fields(self)))


def acceleration(precision, spec, points):
    """Acceleration of a force at `points`: shape (3, n)."""
    term = force_term(spec)

    def components(p, *packs):
        return term.acceleration(p, packs[:3], packs[3:6], packs[6:9], packs[9], packs[10])

    name = ("acceleration", spec)
    return on_packs(precision, components, *points.columns(), outputs=3, parameters=term.parameters(), name=name)


def potential(precision, spec, points):
    """Potential energy by mass of a force at `points`: shape (n,)."""
    term = force_term(spec)

    def components(p, *packs):
        return (term.potential(p, packs[:3], packs[9], packs[10]),)

    name = ("potential", spec)
    return on_packs(precision, components, *points.columns(), parameters=term.parameters(), name=name)[0]


def jacobian(precision, spec, points, gradient):
    """Derivatives of a force's acceleration by position and velocity at `points`: two arrays (3, 3, n).

    Args:
        gradient: of the flow's velocity, shape (3, 3, n).
    """
    term = force_term(spec)

    def components(p, *packs):
        gradients = (packs[11:14], packs[14:17], packs[17:20])
        found = term.jacobian(p, packs[:3], packs[3:6], packs[6:9], gradients, packs[9], packs[10])
        return [entry for matrix in found for row in matrix for entry in row]

    columns = [*points.columns(), *gradient.reshape(9, -1)]
    found = on_packs(
        precision,
        components,
        *columns,
        outputs=18,
        parameters=term.parameters(),
        name=("jacobian", spec),
        one_by_one=True,
    )
    return found.reshape(2, 3, 3, -1)


def gradient(precision, spec, x, t, scene_seed=0):
    """Derivatives of a flow term's velocity by position at points of shape (3, n) and times: (3, 3, n)."""
    term = placed_flow_term(precision, spec, scene_seed)

    def components(p, *packs):
        return [entry for row in term.gradient(p, packs[:3], packs[3]) for entry in row]

    found = on_packs(
        precision,
        components,
        *(*x, t),
        outputs=9,
        parameters=term.parameters(),
        name=("gradient", spec, scene_seed),
        one_by_one=True,
    )
    return found.reshape(3, 3, -1)
