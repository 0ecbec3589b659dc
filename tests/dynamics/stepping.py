"""Steps of every scheme in NumPy, as its tableau or its moves say, apart from the kernels."""

from particlecli.auto.steps import Sampled, implicit_step
from particlecli.dynamics.integrators.base import ImplicitRungeKutta, Splitting


def stepped(scheme, motion, sample, h):
    """The states after a step of each particle's own length, s, shape (n,)."""
    match scheme:
        case ImplicitRungeKutta():
            return implicit_step(scheme, motion, sample, h)
        case Splitting():
            return _split(scheme, motion, sample, h)
        case _:
            return _explicit(scheme, motion, sample, h)


def _explicit(scheme, motion, sample, h):
    slopes = []
    for row, c in zip(scheme.a, scheme.c, strict=True):
        stage = Sampled(sample.states + h * _weighted(row, slopes), sample.times + c * h, sample.weights)
        slopes.append(motion.slopes(*stage))
    return sample.states + h * _weighted(scheme.b, slopes)


def _split(scheme, motion, sample, h):
    states, times = sample.states.copy(), sample.times
    for kind, share in scheme.moves:
        if kind == "drift":
            states[:3] += share * h * states[3:]
            times = times + share * h
        else:
            states[3:] += share * h * motion.slopes(states, times, sample.weights)[3:]
    return states


def _weighted(weights, slopes):
    return sum((weight * slope for weight, slope in zip(weights, slopes, strict=False) if weight), start=0.0)
