"""Images of netpbm: PBM, PGM and PPM, whose header and pixels, binary or in text, are read alike.

Source: the format pages ``pbm``, ``pgm`` and ``ppm`` of netpbm. Headers with line ends of Windows are read as they were
meant: one white space ends a header, but two bytes do in such a file.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.grid import MAX_CELLS

BLOCK = 1 << 20
"""Number of bytes of text, or of pixels, that are read at once."""

MAX_HEADER = 1 << 16
"""Largest header with its comments [bytes]. A pattern that matches megabytes of white space takes gigabytes."""

LONGEST = 5
"""Largest number of digits of a number in text."""

_NAMES = {b"P1": "PBM", b"P2": "PGM", b"P3": "PPM", b"P4": "PBM", b"P5": "PGM", b"P6": "PPM"}

# Numbers are separated by white space and by comments, which end with their line.
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_SIZE = rb"(P[1-6])" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,10})"
_BITS = re.compile(_SIZE + rb"(?:\s|(?=#))")
_GREYS = re.compile(_SIZE + _GAP + rb"(\d{1,5})\s")
_LINE_REST = re.compile(rb"[ \t]+[\r\n]+|\s(?:\s*#[^\r\n]*[\r\n])+\s*")
_COMMENT = re.compile(rb"#[^\r\n]*")

_LONGEST_COMMENT = 1 << 12
"""Largest size of comments between header and pixels [bytes]."""


@dataclass(frozen=True, slots=True)
class ImageHeader:
    """Header of an image.

    Parameters
    ----------
    name : str
        Name of the format, for errors.
    is_text : bool
        Whether the pixels are text.
    width, height : int
        Size [pixels].
    maximum : int
        Value of white; 1 for images of bits.
    channels : int
        1, or 3 for red, green and blue.
    end : int
        Offset of the first byte after the header.
    """

    name: str
    is_text: bool
    width: int
    height: int
    maximum: int
    channels: int
    end: int

    @property
    def size(self) -> str:
        """Size for errors, as ``3×2``."""
        return f"{self.width}×{self.height}"


def read_header(image: Buffer) -> ImageHeader:
    """Return the header of an image.

    Raises
    ------
    InvalidMap
        The file is not an image of netpbm, or the size or the maximum is out of range.
    """
    kind = image[:2]
    found = (_BITS if kind in (b"P1", b"P4") else _GREYS).match(image, 0, MAX_HEADER)
    name = _NAMES.get(kind, "PGM")
    if found is None or kind not in _NAMES:
        raise InvalidMap(f"not a {name} image: it begins with {image[:12]!r}; save the map's image again")
    width, height, maximum = (int(number) for number in (*found.groups()[1:], b"1")[:3])
    if not 1 <= maximum <= 65535:
        raise InvalidMap(f"the {name}'s maximum grey must be from 1 to 65535, not {maximum}")
    if not 1 <= width * height <= MAX_CELLS:
        raise InvalidMap(f"the {name} has {width}×{height} pixels; a map must have from 1 to {MAX_CELLS} cells")
    return ImageHeader(
        name, kind in (b"P1", b"P2", b"P3"), width, height, maximum, 3 if name == "PPM" else 1, found.end()
    )


def netpbm_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width in the header of an image; raises as ``read_header``."""
    header = read_header(image)
    return header.height, header.width


def binary_pixels(image: Buffer, header: ImageHeader, size: int, pixel: int) -> memoryview:
    """Return the bytes of all pixels, without a copy.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.
    header : ImageHeader
        Its header.
    size, pixel : int
        Size of all pixels, and of one [bytes].

    Raises
    ------
    InvalidMap
        The file is truncated, or has data after its pixels.
    """
    start = header.end + _gap_after(image, header.end, size)
    left = len(image) - start - size
    if left < 0:
        missing = -(left // pixel)
        raise InvalidMap(f"the {header.name} is truncated: {missing} of its {header.size} pixels are missing")
    if left > BLOCK or image[start + size :].strip():
        raise InvalidMap(
            f"{left} bytes follow the {header.size} pixels of the {header.name}: the file must have one image"
        )
    return memoryview(image)[start : start + size]


def _gap_after(image: Buffer, end: int, size: int) -> int:
    """Return the number of bytes between header and pixels: the second byte of a line end of Windows, or comments.

    Both are taken for pixels where the file would be too short without them.
    """
    surplus = len(image) - end - size
    if surplus < 1:
        return 0
    if image[end - 1 : end + 1] == b"\r\n":
        return 1
    is_gap = surplus <= _LONGEST_COMMENT and _LINE_REST.fullmatch(image[end - 1 : end + surplus])
    return surplus if is_gap and image[end + size :].strip() else 0


Samples = TypeVar("Samples", bound=np.unsignedinteger)


def text_samples(
    image: Buffer,
    header: ImageHeader,
    kind: type[Samples],
    apart: int,
    read: Callable[[bytes], NDArray[np.unsignedinteger]],
) -> NDArray[Samples]:
    """Return the samples after the header of a text, one after the other.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.
    header : ImageHeader
        Its header.
    kind : type
        Type of the samples.
    apart : int
        Least number of bytes between two samples.
    read : callable
        Returns the samples in a block of the text, which has no comments.

    Raises
    ------
    InvalidMap
        The file has fewer or more samples than its header states.
    """
    # Checked before memory is allocated for the samples.
    _check_count(header, (len(image) - header.end + apart) // (1 + apart), at_most=True)
    count = header.width * header.height * header.channels
    samples, found = np.empty(count, kind), 0
    for text in _text_blocks(image, header.end):
        some = read(text)
        samples[found : found + some.size] = some[: max(0, count - found)]
        found += some.size
    _check_count(header, found)
    return samples


def _text_blocks(image: Buffer, start: int) -> Iterator[bytes]:
    """Yield blocks of the text without comments; a block never ends within a number or a comment."""
    carried = b""
    for at in range(start, len(image), BLOCK):
        text = carried + image[at : at + BLOCK]
        line = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
        comment = text.find(b"#", line)
        if comment >= 0:
            text, carried = text[:comment], b"#"
        elif text[-1:].isspace() or len(last := text.rsplit(None, 1)[-1]) > LONGEST:
            carried = b""
        else:
            text, carried = text[: -len(last)], last
        yield _COMMENT.sub(b"", text)
    yield _COMMENT.sub(b"", carried)


def _check_count(header: ImageHeader, found: int, *, at_most: bool = False) -> None:
    """Raise ``InvalidMap`` unless a text has (or may have ``at_most``) the number of samples that its header states."""
    count = header.width * header.height * header.channels
    if found < count:
        missing = -((found - count) // header.channels)
        least = "at least " if at_most else ""
        raise InvalidMap(f"the {header.name} is truncated: {least}{missing} of its {header.size} pixels are missing")
    if found > count and not at_most:
        extra = found - count
        raise InvalidMap(
            f"{extra} numbers follow the {header.size} pixels of the {header.name}: the file must have one image"
        )


# -- PBM: one bit a pixel, 1 is black ----------------------------------------------------------------------------------

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


# -- PGM and, with colours, PPM: both are read, and binary PGM is written ----------------------------------------------

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
    header : ImageHeader
        Header of the file.
    """

    stored: NDArray[np.unsignedinteger]
    header: ImageHeader

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


def _binary(image: Buffer, header: ImageHeader) -> NDArray[np.unsignedinteger]:
    """Return the samples after the header: one byte each, or two in big-endian order."""
    kind = np.dtype(np.uint8 if header.maximum < 256 else ">u2")
    pixel = header.channels * kind.itemsize
    return np.frombuffer(binary_pixels(image, header, header.width * header.height * pixel, pixel), kind)


def _numbers(header: ImageHeader, text: bytes) -> NDArray[np.uint32]:
    """Return the decimal numbers in a text, which white space separates."""
    wrong = _NO_NUMBER.search(text)
    if wrong is not None:
        raise InvalidMap(
            f"{wrong[0]!r} among the pixels of the {header.name}: pixels must be numbers of at most five digits"
        )
    found = np.fromstring(text, np.uint32, sep=" ") if text.strip() else np.empty(0, np.uint32)
    _check_most(found, header)
    return found


def _check_most(pixels: NDArray[np.unsignedinteger], header: ImageHeader) -> None:
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
