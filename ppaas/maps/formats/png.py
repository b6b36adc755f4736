"""PNG from bytes to pixels, by Pillow: the decoder with most eyes on it, and light enough to draw our plots as well.

Deeper images are taken at eight bits, the higher ones, as SDL_image hands them to map_server.
"""

import io
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.PngImagePlugin import PngImageFile

MAGIC = b"\x89PNG\r\n\x1a\n"

MAX_PIXELS = 1 << 26
"""Most that are decoded: a small file may claim, and hold, any number of them."""

BROKEN = (OSError, SyntaxError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, zlib.error)
"""What Pillow lets through on broken files."""

_GREY, _DEEP_GREY = ("1", "L"), "I;16"


class PngRows:
    """An image that was decoded, of which rows are read as they are asked for.

    Parameters
    ----------
    file : PngImageFile
        By Pillow.

    Raises
    ------
    InvalidMap
        It cannot be decoded.
    """

    def __init__(self, file: "PngImageFile") -> None:
        self._file = file
        with _told():
            file.load()
            if file.mode == "P" and file.palette is None:
                raise ValueError("its colours are numbers of a palette that it lacks")

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        width, height = self._file.size
        return height, width

    def rows(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows, (last − first, width, n): grey (n = 1), red, green, blue (3), or these and alpha (4)."""
        with _told():
            return _pixels(self._file.crop((0, first, self._file.width, last)), self._file.info.get("transparency"))

    def check(self) -> None:
        """Do nothing: all of it was decoded."""


def open_png(image: Buffer) -> PngRows:
    """Read one image of any kind of PNG: grey, RGB or palette, 1 to 16 bits deep, with alpha or without.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        Broken, cut short, with a wrong checksum, or too large.
    """
    # Only maps in PNG need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    with _told():
        checked = PngImageFile(io.BytesIO(image))
        _check_size(*checked.size)
        checked.verify()  # the checksums, which decoding would not look at
        return PngRows(PngImageFile(io.BytesIO(image)))


@contextmanager
def _told() -> Iterator[None]:
    try:
        yield
    except BROKEN as error:
        raise InvalidMap(f"the PNG cannot be read: {error}; save the map's image again") from error


def _check_size(width: int, height: int) -> None:
    if not 1 <= width * height <= MAX_PIXELS:
        raise InvalidMap(f"the PNG is {width}×{height}; a map's PNG has from 1 to {MAX_PIXELS} pixels")


def _pixels(image: "Image", transparent: object) -> NDArray[np.uint8]:
    if image.mode == _DEEP_GREY:
        grey = np.asarray(image)
        high = (grey >> 8).astype(np.uint8)
        if transparent is None:
            return high[..., np.newaxis]
        alpha = np.where(grey == transparent, 0, 255).astype(np.uint8)
        return np.stack((high, high, high, alpha), axis=-1)
    if transparent is None and image.mode in _GREY:
        return np.asarray(image.convert("L"))[..., np.newaxis]
    opaque = transparent is None and image.mode in ("RGB", "P")
    return np.asarray(image.convert("RGB" if opaque else "RGBA"))
