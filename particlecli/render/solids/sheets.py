"""Sheets of pictures for sprites: read from an image beside the scene, or computed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from particlecli.errors import Problem, SceneError
from particlecli.render.colour import decode
from particlecli.render.solids.pictures import SHIPPED

Floats = NDArray[np.float32]

LARGEST = 256
"""Texels across a picture, at most; larger ones are halved."""

MOST_PIXELS = 1 << 26
"""Larger images are refused."""


def load_sheet(sheet: str, grid: tuple[int, int], folder: Path, key: str) -> tuple[Floats, int, int]:
    """The pictures of a sheet with all their levels, each half as fine.

    Args:
        sheet: name of a shipped one, or of an image file.
        grid: columns and rows of pictures in the file.
        folder: the scene's.
        key: the scene's key that names the sheet, for messages.

    Returns:
        Texels of linear light and how much they hide, shape (texels, 4), picture after picture; texels across the
        finest level of a picture; and how many pictures there are.

    Raises:
        SceneError: the file is not there, lies outside the scene's folder, is no image, or has no room for the grid.
    """
    pictures = SHIPPED[sheet]() if sheet in SHIPPED else _read(sheet, grid, folder, key)
    levels = np.concatenate([level.reshape(len(pictures), -1, 4) for level in _levels(pictures)], axis=1)
    return np.ascontiguousarray(levels.reshape(-1, 4), np.float32), pictures.shape[1], len(pictures)


def _read(sheet: str, grid: tuple[int, int], folder: Path, key: str) -> Floats:
    whole = (folder / sheet).resolve()
    try:
        if not whole.is_relative_to(folder.resolve()):
            raise ValueError("lies outside the scene's folder; a scene reads only what is beside or below it")
        with Image.open(whole) as image:
            if image.width * image.height > MOST_PIXELS:
                raise ValueError(f"has more than {MOST_PIXELS} pixels")
            pixels = np.asarray(image.convert("RGBA"), np.float64) / 255
        columns, rows = grid
        height, width = pixels.shape[0] // rows, pixels.shape[1] // columns
        if not width or not height:
            raise ValueError(
                f"has no room for {columns} × {rows} pictures: it is {image.width} × {image.height} pixels"
            )
    except FileNotFoundError:
        message = "there is no such file beside the scene"
    except (Image.DecompressionBombError, OSError, SyntaxError, ValueError) as error:
        unknown = isinstance(error, OSError) and not error.errno
        message = "is no image that can be read" if unknown else str(error) or "cannot be read"
    else:
        cut = pixels[: rows * height, : columns * width].reshape(rows, height, columns, width, 4)
        return _squared(cut.swapaxes(1, 2).reshape(-1, height, width, 4))
    raise SceneError([Problem(key, f"`{sheet}`: {message}")])


def _squared(pictures: NDArray[np.float64]) -> Floats:
    """Pictures of sRGB values with a clear border that makes them square, in linear light, of a power of two texels."""
    count, height, width, _ = pictures.shape
    side = max(height, width)
    size = min(LARGEST, 1 << max(1, (side - 1).bit_length()))
    light = np.concatenate([decode(pictures[..., :3]) * pictures[..., 3:], pictures[..., 3:]], axis=-1)
    square = np.zeros((count, side, side, 4), np.float32)
    top, left = (side - height) // 2, (side - width) // 2
    square[:, top : top + height, left : left + width] = light
    if side == size:
        return square
    return np.stack([_resized(picture, size) for picture in square])


def _resized(picture: Floats, size: int) -> Floats:
    channels = [Image.fromarray(picture[..., k]).resize((size, size), Image.Resampling.BOX) for k in range(4)]
    return np.stack([np.asarray(channel, np.float32) for channel in channels], axis=-1)


def _levels(pictures: Floats) -> list[Floats]:
    levels = [pictures]
    while levels[-1].shape[1] > 1:
        fine = levels[-1]
        size = fine.shape[1] // 2
        levels.append(fine.reshape(len(fine), size, 2, size, 2, 4).mean(axis=(2, 4), dtype=np.float32))
    return levels
