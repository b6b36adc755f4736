"""Pixels of a map's image, whichever format the file has."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.pgm import MAGIC as PGM
from ppaas.maps.pgm import parse_pgm
from ppaas.maps.png import MAGIC as PNG
from ppaas.maps.png import parse_png


@dataclass(frozen=True, slots=True)
class Image:
    """An image of a map.

    Parameters
    ----------
    channels : (height, width, n) uint8 array
        Grey (n = 1); red, green, blue (3); or these and alpha (4), 0 transparent to 255 opaque. Row 0 is the top.
    """

    channels: NDArray[np.uint8]

    @property
    def alpha(self) -> NDArray[np.uint8] | None:
        """How opaque each pixel is, (height, width); None where all are."""
        return self.channels[..., 3] if self.channels.shape[2] == 4 else None


def parse_image(image: bytes) -> Image:
    """Read a PGM or PNG file, told apart by how it begins, as map_server does; its name does not count.

    Raises
    ------
    InvalidMap
        Neither of the two, or broken.
    """
    if image.startswith(PNG):
        return Image(parse_png(image))
    if image.startswith(PGM):
        return Image(parse_pgm(image)[..., np.newaxis])
    raise InvalidMap(f"the map's image is neither PGM (P2, P5) nor PNG: it begins with {image[:12]!r}; convert it")


def media_type(image: bytes) -> str:
    """Return what HTTP calls such a file."""
    return "image/png" if image.startswith(PNG) else "image/x-portable-graymap"
