"""PBM images (netpbm's ``P4``, binary, and ``P1``, text): one bit a pixel, 1 is black."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.netpbm import binary_pixels, read_header, text_samples

MAX_BITS = 1 << 28
"""Largest number of pixels, of which each becomes a byte: about as many as the largest upload of a PGM has."""

_NO_BIT = re.compile(rb"[^01\s]")


@dataclass(frozen=True, slots=True)
class PbmRows:
    """PBM image whose rows are read on demand.

    Parameters
    ----------
    packed : (height, n) uint8 array
        Bits of each row, the highest of a byte first; for a binary file a view of the file itself. Row 0 is the top.
    width : int
        Number of pixels of a row, which the last byte may exceed.
    """

    packed: NDArray[np.uint8]
    width: int

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        return len(self.packed), self.width

    def rows(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows, ``last`` excluded: 0 is black, 255 white."""
        bits = np.unpackbits(self.packed[first:last], axis=1, count=self.width)
        return np.where(bits, np.uint8(0), np.uint8(255))

    def check(self) -> None:
        """Do nothing, since any bits are valid."""


def open_pbm(image: Buffer) -> PbmRows:
    """Open an image of bits; text files are read completely, of binary files only the header.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is not a PBM, has no or too many pixels, is truncated, or has data after its pixels.
    """
    header = read_header(image)
    if header.width * header.height > MAX_BITS:
        raise InvalidMap(f"the PBM has {header.size} pixels; a map's PBM must have at most {MAX_BITS} pixels")
    row = -(-header.width // 8)
    if header.is_text:
        bits = text_samples(image, header, np.uint8, 0, _bits)
        return PbmRows(np.packbits(bits.reshape(header.height, header.width), axis=1), header.width)
    data = binary_pixels(image, header, row * header.height, row)
    return PbmRows(np.frombuffer(data, np.uint8).reshape(header.height, row), header.width)


def _bits(text: bytes) -> NDArray[np.uint8]:
    """Return the bits in a text: digits 0 and 1, which white space may separate."""
    wrong = _NO_BIT.search(text)
    if wrong is not None:
        raise InvalidMap(f"{wrong[0]!r} among the pixels of the PBM: pixels must be 0 or 1")
    return np.frombuffer(b"".join(text.split()), np.uint8) - np.uint8(ord("0"))
