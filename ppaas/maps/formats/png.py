"""Reader of PNG images, by Pillow: a widely reviewed decoder, which also draws this project's plots.

Of images with 16 bits per sample, the upper 8 bits are used, as SDL_image passes them to map_server.
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
"""Limit of the number of pixels, since a small file can decompress to any number of them."""

BROKEN = (OSError, SyntaxError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, zlib.error)
"""Errors that Pillow raises for broken files."""

_GREY, _DEEP_GREY = ("1", "L"), "I;16"


class PngRows:
    """Decoded PNG image, whose rows are converted to arrays on demand.

    Parameters
    ----------
    file : PngImageFile
        The image, opened by Pillow.

    Raises
    ------
    InvalidMap
        The image cannot be decoded.
    """

    def __init__(self, file: "PngImageFile") -> None:
        self._file = file
        with _pillow_errors():
            file.load()
            if file.mode == "P" and file.palette is None:
                raise ValueError("its palette is missing")

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        width, height = self._file.size
        return height, width

    def rows(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows as (last − first, width, n) array: grey (n = 1), red, green, blue (3), or these and alpha (4)."""
        with _pillow_errors():
            return _pixels(self._file.crop((0, first, self._file.width, last)), self._file.info.get("transparency"))

    def check(self) -> None:
        """Do nothing, since the image has been decoded completely."""


def open_png(image: Buffer) -> PngRows:
    """Read a PNG of any kind: grey, RGB or palette, 1 to 16 bits per sample, with or without alpha.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is broken or truncated, has a wrong checksum, or is too large.
    """
    # Imported here, since only PNG maps need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    with _pillow_errors():
        checked = PngImageFile(io.BytesIO(image))
        _check_size(*checked.size)
        checked.verify()  # checksums, which decoding ignores
        return PngRows(PngImageFile(io.BytesIO(image)))


@contextmanager
def _pillow_errors() -> Iterator[None]:
    """Raise Pillow's errors for broken files as ``InvalidMap``."""
    try:
        yield
    except BROKEN as error:
        raise InvalidMap(f"the PNG cannot be read: {error}; save the map's image again") from error


def _check_size(width: int, height: int) -> None:
    if not 1 <= width * height <= MAX_PIXELS:
        raise InvalidMap(f"the PNG has {width}×{height} pixels; a map's PNG must have from 1 to {MAX_PIXELS} pixels")


def _pixels(image: "Image", transparent: object) -> NDArray[np.uint8]:
    """Return the pixels of an image; ``transparent`` is the colour or palette entry without opacity, if any."""
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
