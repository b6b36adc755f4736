"""Parts that the image formats of netpbm share: header, binary pixels, and pixels in text.

Source: the format pages ``pbm``, ``pgm`` and ``ppm`` of netpbm. Headers with line ends of Windows are read as they were
meant: one white space ends a header, but two bytes do in such a file.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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
class Header:
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


def read_header(image: Buffer) -> Header:
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
    return Header(name, kind in (b"P1", b"P2", b"P3"), width, height, maximum, 3 if name == "PPM" else 1, found.end())


def netpbm_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width in the header of an image; raises as ``read_header``."""
    header = read_header(image)
    return header.height, header.width


def binary_pixels(image: Buffer, header: Header, size: int, pixel: int) -> memoryview:
    """Return the bytes of all pixels, without a copy.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.
    header : Header
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
    image: Buffer, header: Header, kind: type[Samples], apart: int, read: Callable[[bytes], NDArray[np.unsignedinteger]]
) -> NDArray[Samples]:
    """Return the samples after the header of a text, one after the other.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.
    header : Header
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


def _check_count(header: Header, found: int, *, at_most: bool = False) -> None:
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
