"""The looks by the names that scenes use. A new one is a file here, its name in the language and a line."""

from particlecli.render.looks.base import Look
from particlecli.render.looks.billboards import Spheres, Sprites
from particlecli.render.looks.blobs import Blobs
from particlecli.render.looks.body import Body
from particlecli.render.looks.dots import Dots
from particlecli.render.looks.glow import Glow
from particlecli.render.looks.ribbons import Ribbons
from particlecli.render.looks.streaks import Streaks
from particlecli.render.looks.surface import Surface
from particlecli.scene.look import Luminous, Merging, Solid

LOOKS: dict[Luminous, Look] = {"dots": Dots(), "glow": Glow(), "streaks": Streaks()}

BODIES: dict[Solid, type[Body]] = {"spheres": Spheres, "sprites": Sprites, "ribbons": Ribbons, "surface": Surface}

LIQUIDS: dict[Merging, type[Blobs]] = {"blobs": Blobs}
