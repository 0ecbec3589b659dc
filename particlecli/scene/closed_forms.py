"""Which groups move by a closed form: x″ = A x + B x′ + c with constant A, B and c along three fixed axes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.expression import Expression
from particlecli.scene.flows import ExpressionFlow, UniformFlow
from particlecli.scene.forces import Drag, Force, ForceField, Gravity
from particlecli.scene.group_checks import Found
from particlecli.scene.model import Scene
from particlecli.scene.planes import Coulomb

Matrix = NDArray[np.float64]

ROUNDING = 1e-12
"""Share of a matrix's size below which an entry counts as zero."""

OTHERWISE = "; use rk4 or dormand_prince, or radau_iia where it is stiff"


class Linear(NamedTuple):
    """How a force that is linear changes with position, N/m, and velocity, N s/m."""

    by_position: Matrix
    by_velocity: Matrix


def linear(force: Force) -> Linear | None:
    """How a force changes if that is the same everywhere and at all times, else none.

    A drag is taken to be relative to a uniform flow.
    """
    nothing = np.zeros((3, 3))
    match force:
        case Gravity():
            return Linear(nothing, nothing)
        case Drag():
            return Linear(nothing, -force.coefficient * np.eye(3))
        case ForceField():
            return _linear_field(force)
        case _:
            return None


def principal_axes(parts: Iterable[Linear]) -> Matrix | None:
    """The axes, as columns, along which forces act independently of each other; none if there are no such axes."""
    total = [np.sum([np.zeros((3, 3)), *matrices], axis=0) for matrices in zip(*parts, strict=True)]
    if all(np.array_equal(matrix, np.diag(np.diag(matrix))) for matrix in total):
        return np.eye(3)
    sizes = [np.abs(matrix).max() or 1.0 for matrix in total]
    if any(np.abs(m - m.T).max() > ROUNDING * size for m, size in zip(total, sizes, strict=True)):
        return None
    # Axes of both are axes of any mixture, and of nothing else but by a chance that is ruled out after.
    mixture = sum(m / size * share for m, size, share in zip(total, sizes, (1.0, 0.6180339887), strict=False))
    axes: Matrix = np.linalg.eigh(mixture)[1]
    return axes if all(_is_diagonal(axes.T @ matrix @ axes) for matrix in total) else None


def closed_form_problems(scene: Scene) -> Iterator[Found]:
    """Why the exact integrator cannot advance a scene."""
    if scene.integrator.type != "exact":
        return
    for name, group in scene.groups.items():
        if group.motion == "fixed":
            continue
        reason = (
            _against_carrier(scene, name, group.flow)
            if group.motion == "first_order"
            else _against_forces(scene, name) or _against_planes(scene, name)
        )
        if reason:
            yield ("integrator", "type"), reason + OTHERWISE
            return


def _against_carrier(scene: Scene, name: str, flow: str | None) -> str | None:
    if flow is None or is_uniform(scene, flow):
        return None
    return f'exact needs a closed form, and the flow "{flow}", which carries "{name}", is not uniform'


def is_uniform(scene: Scene, flow: str) -> bool:
    """Whether a flow is the same everywhere and at all times."""
    return all(
        isinstance(term, UniformFlow)
        or (isinstance(term, ExpressionFlow) and all(c.constant is not None for c in term.velocity))
        for term in scene.flows.get(flow, ())
    )


def _against_forces(scene: Scene, name: str) -> str | None:
    parts = []
    for number, force in _acting(scene, name):
        part = linear(force)
        if part is None:
            why = "is not linear in place and velocity" if isinstance(force, ForceField) else "has none"
            return f"exact needs a closed form, and the {force.type} of forces[{number}] {why}"
        if isinstance(force, Drag) and force.flow is not None and not is_uniform(scene, force.flow):
            return (
                f'exact needs a closed form, and the flow "{force.flow}" of the drag of forces[{number}] is not uniform'
            )
        parts.append(part)
    if parts and principal_axes(parts) is None:
        return f'exact needs forces on "{name}" that act along three fixed axes independently of each other'
    return None


def _against_planes(scene: Scene, name: str) -> str | None:
    """What keeps particles that lie on a plane from moving by the same closed form."""
    if scene.integrator.contact != "located":
        return None
    parts = [part for _, force in _acting(scene, name) if (part := linear(force)) is not None]
    for number, plane in enumerate(scene.planes):
        if (plane.on is not None and name not in plane.on) or plane.on_hit != "bounce":
            continue
        friction = plane.friction
        if (friction.coulomb if isinstance(friction, Coulomb) else friction.viscous) > 0:
            return f"exact needs a closed form, and sliding with the friction of planes[{number}] has none"
        normal = np.array(plane.normal)
        if not all(_is_axis(normal, matrix) for part in parts for matrix in part):
            return (
                f"exact needs a closed form, and on planes[{number}] there is none, because the forces on "
                f'"{name}" do not act along its normal independently'
            )
    return None


def _acting(scene: Scene, name: str) -> list[tuple[int, Force]]:
    return [(n, force) for n, force in enumerate(scene.forces) if force.acts_on(name)]


def _linear_field(force: ForceField) -> Linear | None:
    components = force.force or tuple(force.potential.derivative(name) for name in "xyz")  # type: ignore[union-attr]
    sign = 1.0 if force.potential is None else -1.0
    if not all(component.continuous and "t" not in component.names for component in components):
        return None
    by_position, by_velocity = (_slopes(components, names) for names in ("xyz", "uvw"))
    if by_position is None or by_velocity is None:
        return None
    return Linear(sign * by_position, sign * by_velocity)


def _slopes(components: Sequence[Expression], names: str) -> Matrix | None:
    rows = [[component.derivative(name).constant for name in names] for component in components]
    if any(entry is None for row in rows for entry in row):
        return None
    return np.array(rows, dtype=np.float64)


def _is_diagonal(matrix: Matrix) -> bool:
    return bool((np.abs(matrix - np.diag(np.diag(matrix))) <= ROUNDING * np.abs(matrix).max()).all())


def _is_axis(direction: Matrix, matrix: Matrix) -> bool:
    """Whether a matrix turns a unit vector into a multiple of itself."""
    image = matrix @ direction
    size = np.abs(matrix).max()
    return bool((np.abs(image - (direction @ image) * direction) <= 1e-9 * size).all())
