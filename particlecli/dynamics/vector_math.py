"""Elementary functions on packs, written as plain arithmetic that LLVM turns into SIMD instructions.

Taichi's own `ti.sin`, `ti.exp` and the like call the C library once a lane. These reduce the argument,
evaluate a minimax polynomial and put the result together again, without a branch. They take packs and scalars
alike, of type f32 or f64, and keep that type: literals are made for it, whatever the runtime's `default_fp`.

The coefficients come from the Remez algorithm run in 60 digits; the polynomials' own errors are below 1e-8
(single) and 4e-18 (double), so that rounding decides. Infinite and undefined arguments give what IEEE 754
says. Subnormal numbers count as zero, as the processor is set to do while Taichi is loaded.
Argument reduction after Cody and Waite, "Software Manual for the Elementary Functions" (1980); the logarithm
has the form of FreeBSD's `e_log.c`.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import taichi as ti
from taichi.lang.expr import Expr

# π and ln 2 as sums whose leading terms have so few digits that their products with whole numbers are exact.
_SINGLE_PI = (3.140625, 0.0009675025939941406, 1.5099067240953445e-07, 5.126688303189038e-12)
_DOUBLE_PI = (3.1415926534682512, 1.2154201012607932e-10, 4.044532497591901e-21)
_SINGLE_LN2 = (0.693115234375, 3.1946184945309415e-05)
_DOUBLE_LN2 = (0.6931471805582987, 1.6465949582897082e-12)

# sin r = r + r³ P(r²) for |r| <= π/2
_SINGLE_SINE = (-0.16666659544653203, 0.008333066084933331, -0.00019809590249088193, 2.605750978629957e-06)
_DOUBLE_SINE = (
    -0.16666666666666666, 0.008333333333333194, -0.00019841269841209148, 2.7557319211124366e-06,
    -2.5052106871585007e-08, 1.6058939643064318e-10, -7.642989814193373e-13, 2.7211569281447017e-15,
)  # fmt: skip
# sin 2πa = 2πa + a³ P(a²) for |a| <= 1/4
_SINGLE_TURN = (-41.34167850182859, 81.60215440190687, -76.5718861309273, 39.68271155369109)
_DOUBLE_TURN = (
    -41.341702240399755, 81.60524927607291, -76.70585975273711, 42.058693920175,
    -15.094641505059691, 3.8199249922659995, -0.7177043431117038, 0.10078283436963283,
)  # fmt: skip
# exp r = 1 + r + r² P(r) for |r| <= ln(2)/2
_SINGLE_EXP = (
    0.49999993412685784, 0.16666520104806593, 0.04166839414873173, 0.008368780689673014, 0.001381447122319572,
)  # fmt: skip
_DOUBLE_EXP = (
    0.5000000000000011, 0.1666666666666641, 0.04166666666652919, 0.008333333333495627, 0.0013888888943921454,
    0.00019841269504751636, 2.4801492763973955e-05, 2.7557587357531655e-06, 2.7630378228186743e-07,
    2.4999960208336418e-08,
)  # fmt: skip
# log((1 + s)/(1 − s)) = 2s + s³ P(s²) for |s| <= 0.1716
_SINGLE_LOG = (0.6666677671672342, 0.39977495622614906, 0.298730722225819)
_DOUBLE_LOG = (
    0.6666666666666735, 0.39999999999411107, 0.28571428743260424, 0.22222198476132016, 0.18183569735442331,
    0.15313903297828368, 0.14797507658605685,
)  # fmt: skip
# (1 − exp(−s))/s = P(s) for 0 <= s <= 1
_SINGLE_PHI = (
    0.9999999980429135, -0.4999998050966681, 0.16666349440143657, -0.041647238057265966,
    0.008276253447864522, -0.0013014395901395693, 0.0001292976375032652,
)  # fmt: skip
_DOUBLE_PHI = (
    1.0, -0.49999999999999994, 0.16666666666666255, -0.041666666666575536, 0.008333333332285487,
    -0.0013888888817139722, 0.00019841266684726295, -2.480149410327166e-05, 2.7555431009673385e-06,
    -2.7530940937569074e-07, 2.4801319767281788e-08, -1.931307588763291e-09, 1.0145132050834853e-10,
)  # fmt: skip


class _Format(NamedTuple):
    """A binary floating-point format as the bit tricks need it."""

    integer: Any
    """Integer type of the same size."""
    fraction_bits: int
    bias: int
    sqrt_half: int
    """Bit pattern of √½."""
    smallest_normal: float


_SINGLE = _Format(ti.i32, 23, 127, 0x3F3504F3, 2.0**-126)
_DOUBLE = _Format(ti.i64, 52, 1023, 0x3FE6A09E667F3BCD, 2.0**-1022)


def is_double(x: Expr) -> bool:
    """Whether a pack or scalar has double precision."""
    return bool(x.element_type() == ti.f64)


def _format(x: Expr) -> _Format:
    return _DOUBLE if is_double(x) else _SINGLE


def _integer(x: Expr, value: int) -> Expr:
    return Expr(value, dtype=_format(x).integer)


def literals(x: Expr, *values: float) -> tuple[Expr, ...]:
    """Numbers as literals of the type of a pack or scalar `x`."""
    return tuple(Expr(float(value), dtype=x.element_type()) for value in values)


def polynomial(x: Expr, single: Sequence[float], double: Sequence[float]) -> Expr:
    """c₀ + c₁ x + c₂ x² + … by Horner's rule, with the coefficients for the precision of `x`."""
    *lower, total = literals(x, *(double if is_double(x) else single))
    for coefficient in reversed(lower):
        total = total * x + coefficient
    return total


def reduced(x: Expr, multiple: Expr, terms: Sequence[Expr]) -> Expr:
    """x − multiple Σ terms, largest term first."""
    for term in terms:
        x = x - multiple * term
    return x


@ti.func
def _signed_sine(x, multiple, n):
    """(−1)ⁿ sin(x − multiple π), where that argument is within ±π/2."""
    pi = ti.static(literals(x, *(_DOUBLE_PI if is_double(x) else _SINGLE_PI)))
    low, high = ti.static(literals(x, -1.6, 1.6))
    r = reduced(x, multiple, pi)
    # Past 1e7 or so (single) r is only noise; the result must nevertheless stay within ±1.
    r = ti.select(r > high, high, ti.select(r < low, low, r))
    square = r * r
    sine = r + r * square * polynomial(square, _SINGLE_SINE, _DOUBLE_SINE)
    sign_bit = ti.static(31 if _format(x).integer == ti.i32 else 63)
    odd = ti.cast(n, _format(x).integer) << sign_bit
    return ti.bit_cast(ti.bit_cast(sine, _format(x).integer) ^ odd, x.element_type())


@ti.func
def sin(x):
    """Sine; within 2.5 units in the last place for |x| <= 1e4 (1e5 in double), and within ±1 beyond."""
    half, inverse_pi = ti.static(literals(x, 0.5, 1 / math.pi))
    n = ti.floor(x * inverse_pi + half)
    return _signed_sine(x, n, n)


@ti.func
def cos(x):
    """Cosine, as accurate as `sin`."""
    half, one, inverse_pi = ti.static(literals(x, 0.5, 1.0, 1 / math.pi))
    n = ti.floor(x * inverse_pi)
    return _signed_sine(x, n + half, n + one)


@ti.func
def tan(x):
    """Tangent."""
    return sin(x) / cos(x)


@ti.func
def cos_turns(x):
    """cos(2πx): the argument in turns, whose reduction is exact and therefore cheap."""
    half, quarter, tau = ti.static(literals(x, 0.5, 0.25, math.tau))
    a = quarter - ti.abs(x - ti.floor(x + half))
    square = a * a
    return a * (tau + square * polynomial(square, _SINGLE_TURN, _DOUBLE_TURN))


@ti.func
def _power_of_two(n):
    """2ⁿ for a whole n within the format's exponents."""
    bits = (ti.cast(n, _format(n).integer) + _integer(n, _format(n).bias)) << _format(n).fraction_bits
    return ti.bit_cast(bits, n.element_type())


@ti.func
def exp(x):
    """Exponential, within 1.5 units in the last place."""
    low, high = ti.static(literals(x, *((-746.0, 710.0) if is_double(x) else (-104.0, 89.0))))
    ln2 = ti.static(literals(x, *(_DOUBLE_LN2 if is_double(x) else _SINGLE_LN2)))
    half, one, inverse_ln2 = ti.static(literals(x, 0.5, 1.0, 1 / math.log(2.0)))
    limited = ti.select(x > high, high, ti.select(x < low, low, x))
    n = ti.floor(limited * inverse_ln2 + half)
    r = reduced(limited, n, ln2)
    value = one + (r + r * r * polynomial(r, _SINGLE_EXP, _DOUBLE_EXP))
    # In two factors, because 2ⁿ alone may be past the largest or below the smallest number.
    part = ti.floor(n * half)
    return value * _power_of_two(part) * _power_of_two(n - part)


@ti.func
def log(x):
    """Natural logarithm, within 1 unit in the last place; −∞ at 0, undefined below."""
    half, one, two, smallest = ti.static(literals(x, 0.5, 1.0, 2.0, _format(x).smallest_normal))
    infinity, undefined = ti.static(literals(x, math.inf, math.nan))
    ln2 = ti.static(literals(x, *(_DOUBLE_LN2 if is_double(x) else _SINGLE_LN2)))
    bits = ti.bit_cast(x, _format(x).integer)
    exponent = (bits - _integer(x, _format(x).sqrt_half)) >> _format(x).fraction_bits
    f = ti.bit_cast(bits - (exponent << _format(x).fraction_bits), x.element_type()) - one
    k = ti.cast(exponent, x.element_type())
    s = f / (two + f)
    square = s * s
    half_square = half * f * f
    tail = s * (half_square + square * polynomial(square, _SINGLE_LOG, _DOUBLE_LOG)) + k * ln2[1]
    value = k * ln2[0] - ((half_square - tail) - f)
    value = ti.select(x >= smallest, value, ti.select(x > -smallest, -infinity, undefined))
    return ti.select(x < infinity, value, x)


@ti.func
def mean_decay(s):
    """(1 − exp(−s))/s for s >= 0, without cancellation: the mean of exp(−σ) for σ from 0 to s."""
    (one,) = ti.static(literals(s, 1.0))
    near = polynomial(ti.min(s, one), _SINGLE_PHI, _DOUBLE_PHI)
    return ti.select(s < one, near, (one - exp(-s)) / ti.max(s, one))


@ti.func
def mean_decay_slope(s):
    """The derivative of `mean_decay`, (exp(−s) − mean_decay(s))/s for s >= 0."""
    (one,) = ti.static(literals(s, 1.0))
    near = polynomial(ti.min(s, one), differentiated(_SINGLE_PHI), differentiated(_DOUBLE_PHI))
    return ti.select(s < one, near, (exp(-s) - mean_decay(s)) / ti.max(s, one))


def differentiated(coefficients: Sequence[float]) -> tuple[float, ...]:
    """The coefficients of a polynomial's derivative."""
    return tuple(n * c for n, c in enumerate(coefficients))[1:]


@ti.func
def _real_power(base, exponent):
    zero, half, one, undefined = ti.static(literals(base, 0.0, 0.5, 1.0, math.nan))
    size = exp(exponent * log(ti.abs(base)))
    whole = ti.floor(exponent) == exponent
    odd = ti.floor(exponent * half) != exponent * half
    signed = ti.select(odd, -size, size)
    value = ti.select(base < zero, ti.select(whole, signed, undefined), size)
    return ti.select(exponent == zero, one, value)


def pow(base: Expr | float, exponent: Expr | float) -> Expr:  # noqa: A001
    """`base` to the power `exponent`, undefined for a negative base unless the exponent is a whole number.

    One of the two is a pack or scalar and gives the type. Within 1 unit in the last place in single precision
    (it computes in double); the relative error in double precision grows to |exponent log base| ε.
    """
    given: Expr = base if isinstance(base, Expr) else exponent
    operands = (
        ti.cast(operand, ti.f64) if isinstance(operand, Expr) else Expr(float(operand), dtype=ti.f64)
        for operand in (base, exponent)
    )
    return ti.cast(_real_power(*operands), given.element_type())


# The sum in these is reached only where one operand is undefined. Taichi folds the usual test, a != a, away.
@ti.func
def minimum(a, b):
    """The smaller of two; undefined where one is."""
    return ti.select(a < b, a, ti.select(b <= a, b, a + b))


@ti.func
def maximum(a, b):
    """The larger of two; undefined where one is."""
    return ti.select(a > b, a, ti.select(b >= a, b, a + b))


@ti.func
def clip(x, low, high):
    """`x` kept between `low` and `high`; undefined where one is."""
    return minimum(maximum(x, low), high)
