"""PGM (netpbm's ``P5``, binary, and ``P2``, text) from bytes to pixels and back."""

import re

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import MAX_CELLS

Pixels = NDArray[np.uint8]
"""(height, width) grey values, 0 black to 255 white; row 0 is the top."""

MAGIC = (b"P2", b"P5")

# Between the numbers there is white space, and comments that run to the end of their line.
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_HEADER = re.compile(rb"(P[25])" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,5})\s")
_COMMENT = re.compile(rb"#[^\r\n]*")
_NO_NUMBER = re.compile(rb"[^\d\s]|\d{6}")


def parse_pgm(image: bytes) -> Pixels:
    """Read one image of up to sixteen bits a pixel.

    Parameters
    ----------
    image : bytes
        The whole file.

    Returns
    -------
    (height, width) uint8 array
        Scaled to 0–255 where the file's maximum is another (rounded down, as SDL_image does for map_server).

    Raises
    ------
    InvalidMap
        Not a PGM, without pixels or with too many, cut short, or with something left over.
    """
    header = _HEADER.match(image)
    if header is None:
        raise InvalidMap(f"not a PGM image (P5 or P2): it begins with {image[:12]!r}; save the map's image again")
    width, height, maximum = (int(number) for number in header.groups()[1:])
    if not 1 <= maximum <= 65535:
        raise InvalidMap(f"the PGM's maximum grey is {maximum}; it is from 1 to 65535")
    if not 1 <= width * height <= MAX_CELLS:
        raise InvalidMap(f"the PGM is {width}×{height}; a map has from 1 to {MAX_CELLS} cells")
    numbers = _binary if header[1] == b"P5" else _text
    pixels = numbers(image, header.end(), width, height, maximum).reshape(height, width)
    return _to_bytes(pixels, maximum)


def _binary(image: bytes, start: int, width: int, height: int, maximum: int) -> NDArray[np.unsignedinteger]:
    """Return the pixels behind the header: a byte each, or two with the higher one first."""
    kind = np.dtype(np.uint8 if maximum < 256 else ">u2")
    size = width * height * kind.itemsize
    left = len(image) - start - size
    if left < 0:
        missing = -(left // kind.itemsize)
        raise InvalidMap(f"the PGM is cut short: {missing} of its {width}×{height} pixels are missing")
    if image[start + size :].strip():
        raise InvalidMap(f"{left} bytes follow the {width}×{height} pixels of the PGM; send one image alone")
    return np.frombuffer(image, kind, width * height, start)


def _text(image: bytes, start: int, width: int, height: int, _maximum: int) -> NDArray[np.unsignedinteger]:
    """Return the pixels behind the header: decimal numbers with white space and comments between."""
    body = _COMMENT.sub(b"", image[start:])
    wrong = _NO_NUMBER.search(body)
    if wrong is not None:
        raise InvalidMap(f"{wrong[0]!r} among the pixels of the PGM: they are whole numbers of five digits at most")
    numbers = np.fromstring(body, np.uint32, sep=" ") if body.strip() else np.empty(0, np.uint32)
    left = numbers.size - width * height
    if left < 0:
        raise InvalidMap(f"the PGM is cut short: {-left} of its {width}×{height} pixels are missing")
    if left > 0:
        raise InvalidMap(f"{left} numbers follow the {width}×{height} pixels of the PGM; send one image alone")
    return numbers


def _to_bytes(pixels: NDArray[np.unsignedinteger], maximum: int) -> Pixels:
    most = int(pixels.max())
    if most > maximum:
        raise InvalidMap(f"a pixel of the PGM is {most}, above its maximum grey of {maximum}")
    if maximum == 255:
        return pixels.astype(np.uint8, copy=False)
    return (pixels.astype(np.uint32) * 255 // maximum).astype(np.uint8)


def write_pgm(pixels: Pixels) -> bytes:
    """Return the binary file of (height, width) uint8 pixels, row 0 on top.

    Raises
    ------
    InvalidMap
        Not a two-dimensional array of bytes with at least one pixel.
    """
    if pixels.ndim != 2 or pixels.dtype != np.uint8 or not pixels.size:
        raise InvalidMap(f"a PGM has uint8 pixels in rows and columns, not {pixels.dtype} of {pixels.shape}")
    height, width = pixels.shape
    return b"P5\n%d %d\n255\n" % (width, height) + pixels.tobytes()
