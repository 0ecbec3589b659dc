"""What a look is: how sprites become light."""

from __future__ import annotations

from typing import ClassVar


class Look:
    """How the sprites that a group's particles were projected to are drawn.

    Attributes:
        halo: share of the light that surrounds each particle as a halo, here and in mirrors.
        smeared: whether particles are smeared along their motion while the shutter is open.
        crisp: whether they are discs with sharp edges rather than soft light.
    """

    halo: ClassVar[float]
    smeared: ClassVar[bool] = False
    crisp: ClassVar[bool] = False
