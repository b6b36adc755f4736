"""Binary PGM (netpbm's ``P5``) from bytes to pixels and back."""

import re

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import MAX_CELLS

Pixels = NDArray[np.uint8]
"""(height, width) grey values, 0 black to 255 white; row 0 is the top."""

# Between the numbers there is white space, and comments that run to the end of their line.
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_HEADER = re.compile(rb"P5" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,10})" + _GAP + rb"(\d{1,5})\s")


def parse_pgm(image: bytes) -> Pixels:
    """Read one image of at most eight bits a pixel.

    Parameters
    ----------
    image : bytes
        The whole file.

    Returns
    -------
    (height, width) uint8 array
        Scaled to 0–255 where the file's maximum is less (rounded down, as SDL_image does for map_server).

    Raises
    ------
    InvalidMap
        Not a PGM, of sixteen bits, without pixels or with too many, cut short, or with bytes left over.
    """
    header = _HEADER.match(image)
    if header is None:
        raise InvalidMap(f"not a binary PGM image (P5): it begins with {image[:12]!r}; convert the map to 8-bit PGM")
    width, height, maximum = (int(number) for number in header.groups())
    if not 1 <= maximum <= 255:
        raise InvalidMap(f"the PGM's maximum grey is {maximum}; convert the map to 8 bits (1 to 255)")
    cells = width * height
    if not 1 <= cells <= MAX_CELLS:
        raise InvalidMap(f"the PGM is {width}×{height}; a map has from 1 to {MAX_CELLS} cells")
    left = len(image) - header.end() - cells
    if left < 0:
        raise InvalidMap(f"the PGM is cut short: {-left} of its {width}×{height} pixels are missing")
    if image[header.end() + cells :].strip():
        raise InvalidMap(f"{left} bytes follow the {width}×{height} pixels of the PGM; send one image alone")
    pixels = np.frombuffer(image, np.uint8, cells, header.end()).reshape(height, width)
    return pixels if maximum == 255 else _scaled(pixels, maximum)


def _scaled(pixels: Pixels, maximum: int) -> Pixels:
    if int(pixels.max()) > maximum:
        raise InvalidMap(f"a pixel of the PGM is {pixels.max()}, above its maximum grey of {maximum}")
    return (pixels.astype(np.uint16) * 255 // maximum).astype(np.uint8)


def write_pgm(pixels: Pixels) -> bytes:
    """Return the file of (height, width) uint8 pixels, row 0 on top.

    Raises
    ------
    InvalidMap
        Not a two-dimensional array of bytes with at least one pixel.
    """
    if pixels.ndim != 2 or pixels.dtype != np.uint8 or not pixels.size:
        raise InvalidMap(f"a PGM has uint8 pixels in rows and columns, not {pixels.dtype} of {pixels.shape}")
    height, width = pixels.shape
    return b"P5\n%d %d\n255\n" % (width, height) + pixels.tobytes()
