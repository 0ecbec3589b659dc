import numpy as np
import pytest
import taichi as ti
from taichi.lang.exception import TaichiRuntimeTypeError

from particlecli import runtime


@ti.kernel
def weigh(share: ti.f32, count: ti.i32, values: ti.types.ndarray(dtype=ti.f32, ndim=2), twice: ti.template()):
    for i in range(count):
        for k in range(values.shape[1]):
            values[i, k] = share * values[i, k] * (2 if ti.static(twice) else 1)


def test_numbers_arrays_and_templates_arrive():
    runtime.start("single", 1)
    for shape in ((2, 3), (3, 2)):
        values = np.ones(shape, np.float32)
        weigh(np.float64(0.5), np.int64(1), values, False)
        weigh(1, True, values, True)
        assert values[0].tolist() == [1.0] * shape[1]
        assert values[1].tolist() == [1.0] * shape[1]
        weigh(0.5, 2, values, False)
        assert values[1].tolist() == [0.5] * shape[1]


def test_an_array_in_the_other_order_is_written_too():
    runtime.start("single", 1)
    values = np.asfortranarray(np.ones((2, 3), np.float32))
    weigh(0.5, 2, values, False)
    assert values.tolist() == [[0.5] * 3] * 2


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((0.5, 2.0, np.ones((2, 3), np.float32), False), TaichiRuntimeTypeError),
        (("x", 2, np.ones((2, 3), np.float32), False), TaichiRuntimeTypeError),
        ((0.5, 2, np.ones((2, 3)), False), ValueError),
        ((0.5, 2, np.ones(3, np.float32), False), ValueError),
        ((0.5, 2, np.ones((4, 6), np.float32)[::2, ::2], False), ValueError),
    ],
)
def test_what_a_kernel_does_not_take_is_refused(arguments, error):
    runtime.start("single", 1)
    with pytest.raises(error):
        weigh(*arguments)
