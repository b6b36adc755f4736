"""Images decoded by Pillow, a widely reviewed library, which also draws this project's plots.

Of images with 16 bits per sample, the upper 8 bits are used, as SDL_image passes them to map_server.
"""

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile

MAX_PIXELS = 1 << 26
"""Limit of the number of pixels, since a small file can decompress to any number of them."""

BROKEN = (OSError, SyntaxError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, zlib.error)
"""Errors that Pillow raises for broken files."""

ORIENTATION = 274
"""Tag of TIFF and EXIF."""

_TURNED = range(2, 9)
"""Values of the tag of images whose first row is not their top, or that are mirrored."""

_GREY = ("1", "L")
_DEEP_GREY = ("I;16", "I;16L", "I;16B", "I;16N")
_TOO_DEEP = ("I", "F")
_WITH_ALPHA = ("LA", "PA", "La", "RGBA", "RGBa")


class PillowRows:
    """Decoded image, whose rows are converted to arrays on demand.

    Parameters
    ----------
    file : ImageFile
        The image, opened by Pillow.
    name : str
        Name of the format, for errors.

    Raises
    ------
    InvalidMap
        The image cannot be decoded, or has 32 bits per sample.
    """

    def __init__(self, file: "ImageFile", name: str) -> None:
        self._file = file
        self._name = name
        with pillow_errors(name):
            file.load()
            if file.mode == "P" and file.palette is None:
                raise ValueError("its palette is missing")
            if file.mode in _TOO_DEEP:
                raise ValueError("it has 32 bits per sample, of which map_server and Nav2 read none")

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        width, height = self._file.size
        return height, width

    def rows(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows as (last − first, width, n) array: grey (n = 1), red, green, blue (3), or these and alpha (4)."""
        with pillow_errors(self._name):
            return _pixels(self._file.crop((0, first, self._file.width, last)), self._file.info.get("transparency"))

    def check(self) -> None:
        """Do nothing, since the image has been decoded completely."""


def check_upright(name: str, orientation: object) -> None:
    """Raise ``InvalidMap`` for an orientation by which viewers turn an image, since readers of maps disagree on it."""
    if orientation in _TURNED:
        raise InvalidMap(f"the {name} is turned (orientation {orientation}): save the map's image upright")


@contextmanager
def pillow_errors(name: str) -> Iterator[None]:
    """Raise Pillow's errors for broken files as ``InvalidMap``; ``name`` is the format's name."""
    try:
        yield
    except BROKEN as error:
        raise InvalidMap(f"the {name} cannot be read: {error}; save the map's image again") from error


def check_size(name: str, width: int, height: int) -> None:
    """Raise ``InvalidMap`` if an image has no or more than `MAX_PIXELS` pixels."""
    if not 1 <= width * height <= MAX_PIXELS:
        raise InvalidMap(
            f"the {name} has {width}×{height} pixels; a map's {name} must have from 1 to {MAX_PIXELS} pixels"
        )


def _pixels(image: "Image", transparent: object) -> NDArray[np.uint8]:
    """Return the pixels of an image; ``transparent`` is the colour or palette entry without opacity, if any."""
    if image.mode in _DEEP_GREY:
        grey = np.asarray(image)
        high = (grey >> 8).astype(np.uint8)
        if transparent is None:
            return high[..., np.newaxis]
        alpha = np.where(grey == transparent, 0, 255).astype(np.uint8)
        return np.stack((high, high, high, alpha), axis=-1)
    if transparent is None and image.mode in _GREY:
        return np.asarray(image.convert("L"))[..., np.newaxis]
    opaque = transparent is None and image.mode not in _WITH_ALPHA
    return np.asarray(image.convert("RGB" if opaque else "RGBA"))
