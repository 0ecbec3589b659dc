"""What stands still in a recording: axes, planes, sizes of points, and how the viewer lays it all out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from particlecli.render.camera import View
from particlecli.render.points import PointLook
from particlecli.scene.frames import chain
from particlecli.scene.model import Scene
from particlecli.scene.planes import Plane
from particlecli.scene.poses import Poses
from particlecli.sinks.recording import layout, poses
from particlecli.sinks.recording.writer import Writer

PLANE_COLOR = (120, 130, 150, 40)
NORMAL_COLOR = (160, 170, 190, 255)
NORMAL_SHARE = 0.15
"""Length of the arrow that shows a normal, in parts of the distance of the camera from what it looks at."""

AXES_SHARE = 0.05
"""Length of the axes of coordinate frames, likewise."""


def dress(writer: Writer, scene: Scene, looks: Mapping[str, PointLook]) -> None:
    """Logs axes, planes, what points look like, and the layout."""
    writer.blueprint(_blueprint(scene))
    writer.constant("/", rr.ViewCoordinates.RIGHT_HAND_Y_UP)
    view = _view(scene)
    target, reach = view.position + view.distance * view.forward, view.distance
    for number in range(len(scene.planes)):
        _show_plane(writer, scene, number, target, reach)
    for name, look in looks.items():
        _show_points(writer, f"{layout.PARTICLES}/{name}", look)


def _show_points(writer: Writer, entity: str, look: PointLook) -> None:
    """Logs radius (m, or pixels where negative) and colours; of several, frames tell the classes of points."""
    if len(look.palette) == 1:
        writer.constant(entity, rr.Points3D.from_fields(radii=[look.radius], colors=look.palette))
        return
    classes = [rr.AnnotationInfo(id=place, color=color) for place, color in enumerate(look.palette.tolist())]
    writer.constant(entity, rr.Points3D.from_fields(radii=[look.radius]), rr.AnnotationContext(classes))


def _show_plane(writer: Writer, scene: Scene, number: int, target: NDArray[np.float64], reach: float) -> None:
    """Logs a piece of a plane, and its normal, below the frame that it rides on and in that frame's coordinates."""
    plane = scene.planes[number]
    pose = Poses.of(chain(scene.frames, plane.frame), np.zeros(1))
    reach /= float(pose.scale[0])
    corners, foot = _patch(plane, pose.local(target[:, None])[:, 0], reach)
    carrier = "" if plane.frame is None else poses.entity(scene.frames, plane.frame) + "/"
    entity = f"{carrier}{layout.PLANES}/{number}"
    mesh = rr.Mesh3D(
        vertex_positions=corners,
        triangle_indices=[[0, 1, 2], [0, 2, 3]],
        vertex_normals=[plane.normal] * 4,
        albedo_factor=PLANE_COLOR,
    )
    arrow = rr.Arrows3D(
        origins=[foot],
        vectors=[NORMAL_SHARE * reach * np.array(plane.normal)],
        radii=[0.03 * NORMAL_SHARE * reach],
        colors=[NORMAL_COLOR],
    )
    writer.constant(entity, mesh)
    writer.constant(f"{entity}/normal", arrow)


def _view(scene: Scene) -> View:
    """The camera at t = 0."""
    return View.of(scene.camera, *scene.camera.resolution, scene.frames)


def show_axes(writer: Writer, entity: str, scene: Scene) -> None:
    """Shows the axes of a coordinate frame."""
    writer.constant(entity, rr.TransformAxes3D(AXES_SHARE * _view(scene).distance))


def _patch(plane: Plane, centre: NDArray[np.float64], reach: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners, shape (4, 3), of the piece of a plane that is as wide as the camera is far; and its middle."""
    normal = np.array(plane.normal)
    foot = centre - normal * (normal @ (centre - np.array(plane.point)))
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(normal, axis)
    across *= reach / np.linalg.norm(across)
    along = np.cross(normal, across)
    return np.stack([foot + a * across + b * along for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]), foot


def _blueprint(scene: Scene) -> rrb.Blueprint:
    hidden = [name for name, style in scene.look.groups.items() if style.as_ == "hidden"]
    camera = _view(scene)
    target = camera.position + camera.distance * camera.forward
    view = rrb.Spatial3DView(
        name=scene.title or "Particles",
        origin="/",
        contents=["+ /**", *(f"- /{layout.PARTICLES}/{name}" for name in hidden)],
        background=rrb.Background(color=_rgb(scene.look.background)),
        eye_controls=rrb.EyeControls3D(position=camera.position, look_target=target, eye_up=camera.up),
    )
    plots = [
        rrb.TimeSeriesView(name=name.capitalize(), origin=f"/{layout.PLOTS}/{name}")
        for name in ("alive", "deaths", "energy", "momentum", layout.ERROR)
    ]
    documents = [
        rrb.TextDocumentView(name=name.capitalize(), origin=f"/{name}") for name in (layout.SCENE, layout.REPORT)
    ]
    right = rrb.Tabs(rrb.Vertical(*plots, name="Series"), *documents)
    time = rrb.TimePanel(state="collapsed", timeline=layout.TIME, loop_mode="all")
    return rrb.Blueprint(rrb.Horizontal(view, right, column_shares=[2, 1]), time, rrb.SelectionPanel(state="collapsed"))


def _rgb(color: str) -> tuple[int, int, int]:
    number = int(color.removeprefix("#"), 16)
    return number >> 16, number >> 8 & 255, number & 255
