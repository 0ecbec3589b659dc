"""All groups of a scene that are drawn as bodies, in one layer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.errors import SceneError
from particlecli.frame import Frame
from particlecli.render.camera import View
from particlecli.render.looks import BODIES, LIQUIDS
from particlecli.render.looks.blobs import Blobs
from particlecli.render.looks.body import Body, Subject
from particlecli.render.solids.layer import Layer
from particlecli.render.solids.layer_kernels import BILLBOARDS
from particlecli.render.solids.light import Lighting
from particlecli.render.solids.records import MOST_NUMBERS, NUMBERS
from particlecli.render.tint import tint_of
from particlecli.scene.look import Merging, Solid
from particlecli.scene.model import Scene

Floats = NDArray[np.float32]


class Bodies:
    """The groups that are drawn as bodies.

    Attributes:
        groups: how each of those that are sorted by depth is drawn, by name.
        liquids: likewise of those that merge into one body.
        layer: what they are drawn into.
    """

    def __init__(self, scene: Scene, drawn: dict[str, Solid | Merging], size: tuple[int, int], largest: float) -> None:
        """`drawn` names the looks of some groups; `size` is that of the picture, pixels."""
        light = Lighting.of(scene.look.light)
        places = {name: place for place, name in enumerate(scene.groups)}
        self.groups: dict[str, Body] = {}
        self.liquids: dict[str, Blobs] = {}
        sheets: list[Floats] = []
        looks: list[list[float]] = []
        first = 0
        for name, look in drawn.items():
            style = scene.look.groups[name]
            tint = tint_of(style.color, places[name])
            subject = Subject(name, scene.groups[name], style, tint, light, scene.folder, largest)
            if look == "blobs":
                self.liquids[name] = LIQUIDS[look](subject, size)
                continue
            try:
                body = BODIES[look](subject)
            except SceneError as error:
                raise scene.located(error) from None
            body.place = len(looks)
            texels, across = body.sheet()
            looks.append([body.kind, first, across, 0.0, style.opacity])
            sheets.append(texels)
            first += len(texels)
            self.groups[name] = body
        kinds = sorted({body.kind for body in self.groups.values()})
        numbers = NUMBERS if kinds == [BILLBOARDS] else MOST_NUMBERS
        all_texels = np.concatenate([*sheets, np.zeros((1, 4), np.float32)])
        self.layer = Layer(*size, np.array(looks or [[0.0] * 5], np.float32), all_texels, kinds, numbers)

    @classmethod
    def of(cls, scene: Scene, size: tuple[int, int], largest: float) -> Bodies | None:
        """Those of a scene, if there are any; `largest` is the radius that nothing exceeds, pixels."""
        drawn: dict[str, Solid | Merging] = {}
        for name in scene.groups:
            look = scene.look.groups.get(name)
            if look and (look.as_ in BODIES or look.as_ in LIQUIDS):
                drawn[name] = look.as_
        return cls(scene, drawn, size, largest) if drawn else None

    def needs(self, group: str) -> frozenset[str]:
        """Which fields frames must carry of a group."""
        body = self.groups.get(group) or self.liquids.get(group)
        return body.needs if body else frozenset()

    def aim(self, view: View, planes: Floats, hiding: int) -> None:
        """Take a camera's view; before all else. The first `hiding` planes (normal, height) hide what is below them."""
        caps, first = [], 0
        self._planes, self._hiding = planes, hiding
        for liquid in self.liquids.values():
            liquid.aim(view)
        for body in self.groups.values():
            body.planes, body.hiding = planes, hiding
            cap = body.aim(view)
            if len(cap):
                self.layer.looks[body.place, [1, 3]] = first, 1.0
            caps.append(cap)
            first += len(cap)
        self.layer.aim(view, np.concatenate([*caps, np.zeros((1, 8), np.float32)]))

    def draw(self, frame: Frame, sky: Floats, cover: Floats) -> None:
        """Draw a frame's bodies into the layer; what is refracted shifts in how much is seen of sky and ground."""
        records = self.layer.bodies
        records.clear(sum(body.room(frame.groups[name]) for name, body in self.groups.items()))
        for name, body in self.groups.items():
            if len(frame.groups[name]):
                body.put(frame.groups[name], records)
        self.layer.draw()
        for name, liquid in self.liquids.items():
            liquid.draw(frame.groups[name], self.layer, self._planes, self._hiding, sky, cover)
