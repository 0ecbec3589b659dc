"""The names that recordings are written and read by."""

from __future__ import annotations

APPLICATION = "particlecli"

ABOUT = "about"
"""A recording property: who recorded what."""

FRAME = "frame"
TIME = "sim_time"

PARTICLES = "particles"
SPRINGS = "springs"
PLANES = "planes"
FRAMES = "frames"
PLOTS = "plots"
ERROR = "error"
"""The plot of the estimated errors, m."""

SCENE = "scene"
REPORT = "report"
FILES = "files"

POSITIONS = "Points3D:positions"
COLORS = "Points3D:colors"
SHADES = "Points3D:class_ids"
PALETTE = "AnnotationContext:context"
IDS = "ids"
SCALARS = "Scalars:scalars"
STRIPS = "LineStrips3D:strips"
TRANSLATION = "Transform3D:translation"
QUATERNION = "Transform3D:quaternion"
SCALE = "Transform3D:scale"
TEXT = "TextDocument:text"
FILE_NAME = "name"
FILE_CONTENT = "content"
ABOUT_TITLE = "title"
ABOUT_VERSION = "version"
ABOUT_GROUPS = "groups"


def sums_of(column: str) -> str:
    """The column beside one of rows that holds the CRC-32 of each row's bytes, as Rerun keeps no checksums."""
    return f"{column}.crc32"
