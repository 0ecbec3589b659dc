"""Small scenes for tests of the dynamics, written as the language has them."""

from typing import Any

from particlecli import runtime
from particlecli.dynamics.plan import make_plan
from particlecli.scene.model import Scene


def scene(**parts: Any) -> Scene:
    """A scene of one second, with the given parts; by RK4 where they name no scheme."""
    integrator = {"type": "rk4", **parts.pop("integrator", {})}
    return Scene.model_validate({"duration": 1, "fps": 10, "integrator": integrator, **parts})


def system(threads: int | None = None, **parts: Any):  # type: ignore[no-untyped-def]
    """The system of such a scene, at t = 0."""
    described = scene(**parts)
    plan = make_plan(described)
    runtime.start(described.precision, threads, plan.structure)
    from particlecli.dynamics.system import System

    return System(plan)


def body(position: tuple[float, float, float], velocity: tuple[float, float, float], **more: Any) -> dict[str, Any]:
    """A group of one particle."""
    return {"positions": [position], "velocities": [velocity], **more}
