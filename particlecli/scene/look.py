"""How frames look: a style for each group, the ground, exposure and background."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from particlecli.scene.types import (
    Direction,
    Flag,
    Fraction,
    HexColor,
    KeyedError,
    Name,
    NonNegative,
    Positive,
    Real,
    RelativeFile,
    SceneModel,
    Whole,
    by_key,
    described,
)

Palette = Literal["inferno", "magma", "plasma", "viridis", "turbo", "coolwarm", "twilight", "ice", "fire", "aurora"]
ColorMap = Annotated[
    Annotated[Palette, Tag("palette")] | Annotated[tuple[HexColor, ...], Tag("colors")],
    Discriminator(lambda value: "palette" if isinstance(value, str) else "colors"),
]


class Constant(SceneModel):
    """One colour for all."""

    constant: HexColor = described("#rrggbb")


class Blackbody(SceneModel):
    """Colour and brightness of a glowing body of the particle's temperature (Planck's law, CIE 1931 eye)."""

    blackbody: Positive = described("temperature at which a particle has the brightness of `brightness`, K")


class Mapped(SceneModel):
    """A colour looked up by what the particle is doing."""

    by: Literal["age", "speed", "temperature", "id"] = described(
        "age: share of the lifetime, or s where particles live on; speed: m/s; temperature: K; id: birth index"
    )
    map: ColorMap = described("a named colormap, or two or more colours to blend")
    range: tuple[Real, Real] | None = described("values at the ends of the map", default=None)

    @model_validator(mode="after")
    def _enough(self) -> Self:
        if not isinstance(self.map, str) and len(self.map) < 2:
            raise KeyedError("map", "needs two colours or more")
        if self.range is not None and self.range[0] >= self.range[1]:
            raise KeyedError("range", "the first value must be below the second")
        if self.range is None and self.by in ("speed", "temperature", "id"):
            raise KeyedError("by", f"colour by {self.by} needs a range: [low, high]")
        return self


class ByGroup(SceneModel):
    """A colour of its own for each group, chosen for you."""

    group: Literal[True] = described("true")


def _shorthand(value: Any) -> Any:
    if value == "blackbody":
        return {"blackbody": 1500.0}
    if value == "group":
        return {"group": True}
    if isinstance(value, str):
        return {"constant": value}
    return value


_AnyColor = Annotated[
    Annotated[Constant, Tag("constant")]
    | Annotated[Blackbody, Tag("blackbody")]
    | Annotated[Mapped, Tag("by")]
    | Annotated[ByGroup, Tag("group")],
    by_key("constant", "blackbody", "by", "group"),
]
Color = Annotated[_AnyColor, BeforeValidator(_shorthand, json_schema_input_type=str | _AnyColor)]


PLAIN_PIXELS = 1.4
"""Radius of particles of which the scene does not say how large they are, pixels at 720 lines."""

Luminous = Literal["dots", "glow", "streaks"]
"""Looks that are light, which adds up."""

Solid = Literal["spheres", "sprites", "ribbons", "surface"]
"""Looks of bodies, which hide what is behind them."""

Merging = Literal["blobs"]
"""Looks of particles that merge into one body."""

Drawn = Literal[Luminous, Solid, Merging]
"""The looks that are drawn; each has a file of its own in the renderer."""

SHEETS = ("smoke", "flame", "snow", "leaf")
"""Sheets of pictures that are shipped."""

SHEET_ENDINGS = (".png", ".jpg", ".jpeg", ".webp")


def _known_sheet(sheet: str) -> str:
    if sheet in SHEETS:
        return sheet
    if "." not in sheet:
        raise ValueError(f"is neither one of {', '.join(SHEETS)} nor an image file ({', '.join(SHEET_ENDINGS)})")
    return RelativeFile(SHEET_ENDINGS).check(sheet)


Sheet = Annotated[str, AfterValidator(_known_sheet)]
Side = Annotated[Whole, Field(ge=1, le=64)]


_ONLY_FOR: dict[str, tuple[Solid | Merging, ...]] = {
    "opacity": ("spheres", "sprites", "ribbons", "surface", "blobs"),
    "liquid": ("blobs",),
    "sheet": ("sprites",),
    "grid": ("sprites",),
    "spin": ("sprites",),
    "sheet_rate": ("sprites",),
}


class Liquid(SceneModel):
    """What merging blobs are made of."""

    merge: Annotated[float, Field(ge=0.2, le=3)] = described(
        "how far around a blob it draws others to it, radii: 0.2: drops that touch; 3: one smooth body", default=1.0
    )
    stretch: NonNegative = described("blobs are drawn out by the way that they go in so long, s", default=0.0)
    metal: Fraction = described("0: water, slime or wax; 1: a metal, which mirrors all", default=0.0)
    glow: NonNegative = described("light it gives itself, as lava does, for each light of its colour", default=0.0)


class GroupLook(SceneModel):
    """How the particles of a group are drawn."""

    as_: Literal[Drawn, "hidden"] = described(
        "light: dots: crisp points; glow: soft with a halo; streaks: smeared over the shutter. Bodies, which hide what "
        "is behind them: sprites: pictures; spheres; ribbons: along the particles of a line, of hair or of a list; "
        "surface: a skin over a grid; blobs: merge into one liquid body. Or hidden",
        default="glow",
        alias="as",
    )
    radius: Positive | None = described("radius of a particle, m; seen through the camera", default=None)
    pixels: Positive | None = described(
        "radius on the picture instead, pixels at 720 lines; neither: 1.4", default=None
    )
    color: Color = described(
        "#rrggbb, blackbody, group, {blackbody: K}, or {by: …, map: …, range: […]}",
        default=ByGroup(group=True),
    )
    brightness: NonNegative = described("light a particle gives, 1 is plain", default=1.0)
    shutter: Fraction = described("part of the frame interval that the shutter is open; for streaks", default=0.5)
    opacity: Fraction = described("how much bodies hide of what is behind them; 0: glass, or light", default=1.0)
    shadow: Fraction = described("how much of the light its particles take from planes", default=0.0)
    liquid: Liquid | None = described("what blobs are made of; none: as its defaults say", default=None)
    sheet: Sheet | None = described(
        f"pictures of sprites: {', '.join(SHEETS)}, or an image file beside the scene; they follow one another over "
        "the lifetime, or where particles live on each has one of its own; none: smoke",
        default=None,
    )
    grid: tuple[Side, Side] | None = described(
        "columns and rows of pictures in an image file; none: 1, 1", default=None
    )
    sheet_rate: Positive | None = described(
        "pictures of a sheet a second, over and over, each particle beginning at one of its own; none: once over the "
        "lifetime",
        default=None,
    )
    spin: NonNegative | None = described(
        "sprites begin at angles of their own and turn either way, at most so fast, rad/s; none: they stand upright",
        default=None,
    )
    fade_in: Fraction = described("share of the lifetime in which it becomes visible", default=0.0)
    fade_out: Fraction = described("share of the lifetime, at its end, in which it fades", default=0.0)

    @model_validator(mode="after")
    def _one_size(self) -> Self:
        if self.radius is not None and self.pixels is not None:
            raise KeyedError("pixels", "give radius (metres) or pixels, not both")
        return self

    @model_validator(mode="after")
    def _fits_its_look(self) -> Self:
        for key, looks in _ONLY_FOR.items():
            if getattr(self, key) != type(self).model_fields[key].default and self.as_ not in looks:
                raise KeyedError(key, f"goes with `as: {'` or `as: '.join(looks)}`")
        for key in ("fade_in", "fade_out"):
            if getattr(self, key) > 0 and self.as_ in ("ribbons", "surface"):
                raise KeyedError(key, "ribbons and surfaces do not fade")
        if self.grid is not None and self.image is None:
            raise KeyedError("grid", "goes with a `sheet` that is an image file")
        return self

    @property
    def image(self) -> str | None:
        """The file of the sheet; none where it is a shipped one."""
        return None if self.sheet in SHEETS else self.sheet


class Ground(SceneModel):
    """How planes are drawn."""

    color: HexColor = described("colour of the surface", default="#3a3a40")
    brightness: NonNegative = described(
        "soft light from above on the surface; 0: only glow is seen on it", default=0.12
    )
    reflection: Fraction = described("how much of the glow it mirrors, softly", default=0.35)
    roughness: Fraction = described("how much mirrored light spreads: 0 a mirror, 1 dull", default=0.35)
    haze: Positive | None = described(
        "distance at which the ground fades into the sky, m; none: from the camera's distance", default=None
    )
    visible: Flag = described("draw the planes", default=True)


class Light(SceneModel):
    """The light that falls on bodies, and of which they throw shadows on planes."""

    direction: Direction = described("where it comes from", default=(0.36, 0.8, 0.48))
    color: HexColor = described("colour of the sun or lamp, far away", default="#fff1dc")
    brightness: NonNegative = described("how bright it is, 1 is plain", default=1.0)
    sky: HexColor = described("colour of the soft light from above", default="#5d7396")


class Look(SceneModel):
    """How frames look."""

    background: HexColor = described("colour of the sky", default="#05060a")
    exposure: Positive = described("brightness of the whole picture before the tone curve", default=1.0)
    bloom: Fraction = described("share of the light that the lens scatters into a wide halo", default=0.15)
    light: Light = described("the light that falls on bodies", default=Light())
    ground: Ground = described("how planes are drawn", default=Ground())
    groups: dict[Name, GroupLook] = described("how each group is drawn; a group not named glows", default={})
