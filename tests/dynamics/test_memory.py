import numpy as np
import pytest
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.memory import FieldMemory

PACK = ti.types.vector(16, ti.f32)


def test_views_are_the_memory_of_fields_in_any_tree():
    runtime.start("single", 1)
    memory, rng = FieldMemory(), np.random.default_rng(0)
    own = ti.field(PACK)
    builder = ti.FieldsBuilder()
    builder.dense(ti.ij, (3, 5)).place(own)
    builder.finalize()
    fields = [
        own,
        ti.field(ti.f32, shape=7),
        ti.field(ti.i32, shape=(2, 3)),
        ti.field(PACK, shape=(2, 3)),
        ti.Vector.field(3, ti.f32, shape=4),
        ti.Matrix.field(2, 3, ti.f64, shape=2),
    ]
    shapes = [(3, 5, 16), (7,), (2, 3), (2, 3, 16), (4, 3), (2, 2, 3)]
    contents = [(100 * rng.normal(size=shape)).round() for shape in shapes]
    views = [memory.view(field, values) for field, values in zip(fields, contents, strict=True)]
    memory.open()
    for view, field, values in zip(views, fields, contents, strict=True):
        assert view.array.shape == values.shape
        assert np.array_equal(field.to_numpy(), values)
        view.array[...] = values + 1
        assert np.array_equal(field.to_numpy(), values + 1)


def test_a_view_ends_with_the_runtime():
    runtime.start("single", 1)
    view = FieldMemory().view(ti.field(ti.f32, shape=3))
    assert view.array.shape == (3,)
    runtime.start("double", 1)
    with pytest.raises(RuntimeError, match="started anew"):
        _ = view.array
