"""What every sink does with frames and pictures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import Curve, Frame

Image = NDArray[np.uint8]
"""A picture: shape (height, width, 3), sRGB, rows from the top."""


class Sink(ABC):
    """Takes the frames of a run, in order, and makes one output of them.

    A sink writes under a temporary name; the final name appears when the output is complete.
    """

    needs_image: ClassVar[bool] = False
    """Whether `write` is to be given pictures."""

    needs_series: ClassVar[bool] = False
    """Whether frames are to carry `series`."""

    @property
    @abstractmethod
    def files(self) -> tuple[Path, ...]:
        """Files and folders it leaves behind, by their final names."""

    def needs(self, group: str) -> frozenset[str]:  # noqa: ARG002
        """The optional fields of `GroupFrame` it reads of a group."""
        return frozenset()

    @abstractmethod
    def open(self) -> None:
        """Gets ready to write; raises OutputError when the place cannot be written."""

    @abstractmethod
    def write(self, frame: Frame, image: Image | None) -> None:
        """Takes the next frame and its picture; the caller may reuse both afterwards."""

    def conclude(self, report: str, errors: Mapping[str, Curve]) -> None:  # noqa: B027 - most have no place for it
        """Takes what is known after the last frame, before `close`.

        Args:
            report: of the run, JSON.
            errors: the estimated error by group, m.
        """

    @abstractmethod
    def close(self) -> None:
        """Completes the output and gives it its final name; raises OutputError when that fails."""

    @abstractmethod
    def abort(self) -> None:
        """Stops and removes what was begun. Never raises; does nothing before `open` or after `close`."""
