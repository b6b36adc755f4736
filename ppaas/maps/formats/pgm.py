"""PGM images (netpbm's ``P5``, binary, and ``P2``, text) and, with colours, PPM (``P6``, ``P3``).

Images of both kinds are read, and binary PGM is written.
"""

import re
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.netpbm import BLOCK, Header, binary_pixels, read_header, text_samples

Pixels = NDArray[np.uint8]
"""(height, width) grey values, 0 black to 255 white, or (height, width, 3) of red, green, blue; row 0 is the top."""

_NO_NUMBER = re.compile(rb"[^\d\s]|\d{6}")


@dataclass(frozen=True, slots=True)
class PgmRows:
    """PGM or PPM image whose rows are read on demand.

    Parameters
    ----------
    stored : (height, width) or (height, width, 3) array
        Pixels of the file, not scaled; for a binary file a view of the file itself. Row 0 is the top.
    header : Header
        Header of the file.
    """

    stored: NDArray[np.unsignedinteger]
    header: Header

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        return self.header.height, self.header.width

    def rows(self, first: int, last: int) -> Pixels:
        """Return rows, ``last`` excluded, scaled to 0–255; ``InvalidMap`` if a pixel is above the maximum."""
        pixels, maximum = self.stored[first:last], self.header.maximum
        _check_most(pixels, self.header)
        if maximum == 255:
            return pixels.astype(np.uint8, copy=False)
        return (pixels.astype(np.uint32) * 255 // maximum).astype(np.uint8)

    def check(self) -> None:
        """Raise ``InvalidMap`` if any pixel is above the maximum."""
        height, width = self.shape
        if self.header.maximum == np.iinfo(self.stored.dtype).max:
            return
        step = max(1, BLOCK // width)
        for first in range(0, height, step):
            _check_most(self.stored[first : first + step], self.header)


def open_pgm(image: Buffer) -> PgmRows:
    """Open an image of up to 16 bits per sample; text files are read completely, of binary files only the header.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is not a PGM or PPM, has no or too many pixels, is truncated, or has data after its pixels.
    """
    header = read_header(image)
    if header.is_text:
        stored: NDArray[np.unsignedinteger] = text_samples(image, header, np.uint16, 1, partial(_numbers, header))
    else:
        stored = _binary(image, header)
    colours = () if header.channels == 1 else (header.channels,)
    return PgmRows(stored.reshape(header.height, header.width, *colours), header)


def _binary(image: Buffer, header: Header) -> NDArray[np.unsignedinteger]:
    """Return the samples after the header: one byte each, or two in big-endian order."""
    kind = np.dtype(np.uint8 if header.maximum < 256 else ">u2")
    pixel = header.channels * kind.itemsize
    return np.frombuffer(binary_pixels(image, header, header.width * header.height * pixel, pixel), kind)


def _numbers(header: Header, text: bytes) -> NDArray[np.uint32]:
    """Return the decimal numbers in a text, which white space separates."""
    wrong = _NO_NUMBER.search(text)
    if wrong is not None:
        raise InvalidMap(
            f"{wrong[0]!r} among the pixels of the {header.name}: pixels must be numbers of at most five digits"
        )
    found = np.fromstring(text, np.uint32, sep=" ") if text.strip() else np.empty(0, np.uint32)
    _check_most(found, header)
    return found


def _check_most(pixels: NDArray[np.unsignedinteger], header: Header) -> None:
    most = int(pixels.max(initial=0))
    if most > header.maximum:
        raise InvalidMap(f"the {header.name} has a pixel of {most}, above its maximum grey of {header.maximum}")


def write_pgm(pixels: Pixels) -> bytes:
    """Return the binary PGM file of (height, width) uint8 pixels; row 0 is the top.

    Raises
    ------
    InvalidMap
        The array is not two-dimensional, not of type uint8, or empty.
    """
    if pixels.ndim != 2 or pixels.dtype != np.uint8 or not pixels.size:
        raise InvalidMap(f"expected rows of uint8 pixels for a PGM, not {pixels.dtype} of shape {pixels.shape}")
    height, width = pixels.shape
    return b"P5\n%d %d\n255\n" % (width, height) + pixels.tobytes()
