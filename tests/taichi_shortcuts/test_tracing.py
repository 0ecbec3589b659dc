import numpy as np
import pytest
import taichi as ti
from taichi.lang.exception import TaichiCompilationError, TaichiNameError

from particlecli import runtime

Numbers = ti.types.ndarray(dtype=ti.i32, ndim=1)


@ti.func
def power(base, exponent: ti.template()):
    """A function that is walked while it is walked."""
    result = 1
    if ti.static(exponent > 0):
        result = base * power(base, exponent - 1) + 0 * power(base, 0)
    return result


@ti.func
def spread(values: ti.template()):
    total = 0
    for k in ti.static(range(3)):
        total += values[k]
    return total


@ti.data_oriented
class Scale:
    def __init__(self, factor):
        self.factor = factor

    @ti.func
    def of(self, value):
        return self.factor * value

    @ti.kernel
    def scale(self, numbers: Numbers):
        for i in range(numbers.shape[0]):
            numbers[i] = self.of(numbers[i])


@ti.kernel
def compute(numbers: Numbers, exponent: ti.template()):
    for i in range(numbers.shape[0]):
        numbers[i] = power(numbers[i], exponent) + spread([1, power(2, 2), numbers[i]])


@ti.kernel
def faulty(numbers: Numbers):
    for i in range(numbers.shape[0]):
        numbers[i] = power(nothing, 1)  # noqa: F821


@pytest.fixture(autouse=True)
def started() -> None:
    runtime.start("single", 1)


@pytest.mark.parametrize("exponent", [0, 1, 3])
def test_functions_are_inlined_at_each_call(exponent):
    numbers = np.array([2, 3], np.int32)
    compute(numbers, exponent)
    assert numbers.tolist() == [2**exponent + 1 + 4 + 2, 3**exponent + 1 + 4 + 3]


def test_methods_see_their_own_object():
    for factor in (2, 5):
        numbers = np.array([1, 3], np.int32)
        Scale(factor).scale(numbers)
        assert numbers.tolist() == [factor, 3 * factor]


def test_a_faulty_kernel_is_told_with_its_file_and_line():
    with pytest.raises((TaichiNameError, TaichiCompilationError)) as caught:
        faulty(np.zeros(1, np.int32))
    line = faulty.__wrapped__.__code__.co_firstlineno + 3
    assert f'test_tracing.py", line {line}, in faulty' in str(caught.value)
    assert '"nothing" is not defined' in str(caught.value)
