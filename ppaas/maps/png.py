"""PNG from bytes to pixels, by Pillow: the decoder with most eyes on it, and light enough to draw our plots as well.

Deeper images are taken at eight bits, the higher ones, as SDL_image hands them to map_server.
"""

import io
import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap

if TYPE_CHECKING:
    from PIL.PngImagePlugin import PngImageFile

MAGIC = b"\x89PNG\r\n\x1a\n"

MAX_PIXELS = 1 << 26
"""Most that are decoded: a small file may claim, and hold, any number of them."""

# What Pillow lets through on broken files.
_BROKEN = (OSError, SyntaxError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, zlib.error)

_GREY, _DEEP_GREY = ("1", "L"), "I;16"


def parse_png(image: bytes) -> NDArray[np.uint8]:
    """Read one image of any kind of PNG: grey, RGB or palette, 1 to 16 bits deep, with alpha or without.

    Parameters
    ----------
    image : bytes
        The whole file.

    Returns
    -------
    (height, width, n) uint8 array
        Grey (n = 1); red, green, blue (3); or these and alpha (4), which grey with alpha becomes as well.

    Raises
    ------
    InvalidMap
        Broken, cut short, with a wrong checksum, or too large.
    """
    # Only maps in PNG need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    try:
        checked = PngImageFile(io.BytesIO(image))
        _check_size(*checked.size)
        checked.verify()  # the checksums, which decoding would not look at
        return _pixels(PngImageFile(io.BytesIO(image)))
    except _BROKEN as error:
        raise InvalidMap(f"the PNG cannot be read: {error}; save the map's image again") from error


def _check_size(width: int, height: int) -> None:
    if not 1 <= width * height <= MAX_PIXELS:
        raise InvalidMap(f"the PNG is {width}×{height}; a map's PNG has from 1 to {MAX_PIXELS} pixels")


def _pixels(file: "PngImageFile") -> NDArray[np.uint8]:
    if file.mode == "P" and file.palette is None:
        raise ValueError("its colours are numbers of a palette that it lacks")
    transparent = file.info.get("transparency")
    if file.mode == _DEEP_GREY:
        grey = np.asarray(file)
        high = (grey >> 8).astype(np.uint8)
        if transparent is None:
            return high[..., np.newaxis]
        alpha = np.where(grey == transparent, 0, 255).astype(np.uint8)
        return np.stack((high, high, high, alpha), axis=-1)
    if transparent is None and file.mode in _GREY:
        return np.asarray(file.convert("L"))[..., np.newaxis]
    opaque = transparent is None and file.mode in ("RGB", "P")
    return np.asarray(file.convert("RGB" if opaque else "RGBA"))
