"""PGM images (netpbm's ``P5``, binary, and ``P2``, text): reading, and writing of binary files."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.grid import MAX_CELLS

Pixels = NDArray[np.uint8]
"""(height, width) grey values, 0 black to 255 white; row 0 is the top."""

MAGIC = (b"P2", b"P5")

# Numbers are separated by white space and by comments, which end with their line.
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_HEADER = re.compile(rb"(P[25])" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,5})\s")
_COMMENT = re.compile(rb"#[^\r\n]*")
_NO_NUMBER = re.compile(rb"[^\d\s]|\d{6}")

_LONGEST = 5
"""Largest number of digits of a pixel."""

_BLOCK = 1 << 20
"""Number of bytes of text, or of pixels, that are read at once."""


@dataclass(frozen=True, slots=True)
class PgmRows:
    """PGM image whose rows are read on demand.

    Parameters
    ----------
    stored : (height, width) array
        Pixels of the file, not scaled; for a binary file a view of the file itself. Row 0 is the top.
    maximum : int
        Value of white.
    """

    stored: NDArray[np.unsignedinteger]
    maximum: int

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        height, width = self.stored.shape
        return height, width

    def rows(self, first: int, last: int) -> Pixels:
        """Return rows, ``last`` excluded, scaled to 0–255; ``InvalidMap`` if a pixel is above the maximum."""
        return _to_bytes(self.stored[first:last], self.maximum)

    def check(self) -> None:
        """Raise ``InvalidMap`` if any pixel is above the maximum."""
        height, width = self.shape
        if self.maximum == np.iinfo(self.stored.dtype).max:
            return
        step = max(1, _BLOCK // width)
        for first in range(0, height, step):
            _check_most(self.stored[first : first + step], self.maximum)


def open_pgm(image: Buffer) -> PgmRows:
    """Open an image of up to 16 bits per pixel; text files are read completely, of binary files only the header.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is not a PGM, has no or too many pixels, is truncated, or has data after its pixels.
    """
    header = _HEADER.match(image)
    if header is None:
        raise InvalidMap(f"not a PGM image (P5 or P2): it begins with {image[:12]!r}; save the map's image again")
    width, height, maximum = (int(number) for number in header.groups()[1:])
    if not 1 <= maximum <= 65535:
        raise InvalidMap(f"the PGM's maximum grey must be from 1 to 65535, not {maximum}")
    if not 1 <= width * height <= MAX_CELLS:
        raise InvalidMap(f"the PGM has {width}×{height} pixels; a map must have from 1 to {MAX_CELLS} cells")
    if header[1] == b"P5":
        stored = _binary(image, header.end(), width, height, maximum)
    else:
        stored = _text(image, header.end(), width, height, maximum)
    return PgmRows(stored.reshape(height, width), maximum)


def parse_pgm(image: Buffer) -> Pixels:
    """Read an image of up to 16 bits per pixel.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Returns
    -------
    (height, width) uint8 array
        Pixels, scaled to 0–255 if the file has another maximum (rounded down, as SDL_image does for map_server).

    Raises
    ------
    InvalidMap
        As for ``open_pgm``, or a pixel is above the maximum.
    """
    opened = open_pgm(image)
    return opened.rows(0, opened.shape[0])


def _binary(image: Buffer, start: int, width: int, height: int, maximum: int) -> NDArray[np.unsignedinteger]:
    """Return the pixels after the header: one byte each, or two in big-endian order."""
    kind = np.dtype(np.uint8 if maximum < 256 else ">u2")
    size = width * height * kind.itemsize
    left = len(image) - start - size
    if left < 0:
        missing = -(left // kind.itemsize)
        raise InvalidMap(f"the PGM is truncated: {missing} of its {width}×{height} pixels are missing")
    if left > _BLOCK or image[start + size :].strip():
        raise InvalidMap(f"{left} bytes follow the {width}×{height} pixels of the PGM: the file must have one image")
    return np.frombuffer(memoryview(image), kind, width * height, start)


def _text(image: Buffer, start: int, width: int, height: int, maximum: int) -> NDArray[np.unsignedinteger]:
    """Return the pixels after the header: decimal numbers, separated by white space and comments."""
    count = width * height
    # Each pixel takes at least a digit and a space. This is checked before memory is allocated for them.
    if 2 * count - 1 > len(image) - start:
        missing = count - (len(image) - start + 1) // 2
        raise InvalidMap(f"the PGM is truncated: at least {missing} of its {width}×{height} pixels are missing")
    pixels, found = np.empty(count, np.uint16), 0
    for text in _texts(image, start):
        numbers = _numbers(text)
        _check_most(numbers, maximum)
        pixels[found : found + numbers.size] = numbers[: max(0, count - found)]
        found += numbers.size
    if found < count:
        raise InvalidMap(f"the PGM is truncated: {count - found} of its {width}×{height} pixels are missing")
    if found > count:
        extra = found - count
        raise InvalidMap(f"{extra} numbers follow the {width}×{height} pixels of the PGM: the file must have one image")
    return pixels


def _texts(image: Buffer, start: int) -> Iterator[bytes]:
    """Yield blocks of the text without comments; a block never ends within a number or a comment."""
    carried = b""
    for at in range(start, len(image), _BLOCK):
        text = carried + image[at : at + _BLOCK]
        line = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
        comment = text.find(b"#", line)
        if comment >= 0:
            text, carried = text[:comment], b"#"
        elif text[-1:].isspace() or len(last := text.rsplit(None, 1)[-1]) > _LONGEST:
            carried = b""
        else:
            text, carried = text[: -len(last)], last
        yield _COMMENT.sub(b"", text)
    yield _COMMENT.sub(b"", carried)


def _numbers(text: bytes) -> NDArray[np.uint32]:
    wrong = _NO_NUMBER.search(text)
    if wrong is not None:
        raise InvalidMap(f"{wrong[0]!r} among the pixels of the PGM: pixels must be numbers of at most five digits")
    return np.fromstring(text, np.uint32, sep=" ") if text.strip() else np.empty(0, np.uint32)


def _check_most(pixels: NDArray[np.unsignedinteger], maximum: int) -> None:
    most = int(pixels.max(initial=0))
    if most > maximum:
        raise InvalidMap(f"the PGM has a pixel of {most}, above its maximum grey of {maximum}")


def _to_bytes(pixels: NDArray[np.unsignedinteger], maximum: int) -> Pixels:
    _check_most(pixels, maximum)
    if maximum == 255:
        return pixels.astype(np.uint8, copy=False)
    return (pixels.astype(np.uint32) * 255 // maximum).astype(np.uint8)


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
