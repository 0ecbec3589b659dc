"""Integration schemes with one wrong entry, which tests must notice."""

from dataclasses import replace

import pytest

from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ClosedForm, Splitting


def perturbed(scheme):
    """The scheme with each of its coefficients wrong by a tenth, one at a time.

    The last stage of an adaptive scheme serves its error estimate alone and is left out here, and so are the stages
    of schemes of first order, which stay of first order.
    """
    if isinstance(scheme, ClosedForm):
        return
    if isinstance(scheme, Splitting):
        for i, (kind, share) in enumerate(scheme.moves):
            moves = (*scheme.moves[:i], (kind, share * 1.1), *scheme.moves[i + 1 :])
            yield f"move {i}", replace(scheme, moves=moves)
        return
    stages = 0 if scheme.order == 1 else len(scheme.b) - (scheme.b[-1] == 0.0)
    for i, row in enumerate(scheme.a[:stages]):
        for j, entry in enumerate(row):
            if entry:
                wrong = (*row[:j], entry * 1.1, *row[j + 1 :])
                yield f"a[{i}][{j}]", replace(scheme, a=(*scheme.a[:i], wrong, *scheme.a[i + 1 :]))
    for part in ("b", "c"):
        values = getattr(scheme, part)
        for i, entry in enumerate(values[: stages if part == "c" else None]):
            if entry:
                yield f"{part}[{i}]", replace(scheme, **{part: (*values[:i], entry * 1.1, *values[i + 1 :])})


def wrong_schemes():
    """Names of schemes, each with the scheme as it is but for one entry, as parameters of a test."""
    return list(_wrong_schemes())


def _wrong_schemes():
    for name, scheme in SCHEMES.items():
        for entry, wrong in perturbed(scheme):
            yield pytest.param(name, wrong, id=f"{name} {entry}")
