"""Pixels of a map's image, whichever format the file has."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.pgm import MAGIC as PGM
from ppaas.maps.formats.pgm import PgmRows, open_pgm
from ppaas.maps.formats.png import MAGIC as PNG
from ppaas.maps.formats.png import PngRows, open_png


@dataclass(frozen=True, slots=True)
class MapImage:
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


class ImageRows:
    """An image of which rows are read as they are asked for, whichever format the file has.

    Parameters
    ----------
    source : PgmRows or PngRows
        The file.
    """

    def __init__(self, source: PgmRows | PngRows) -> None:
        self._source = source
        self.shape = source.shape

    def rows(self, first: int, last: int) -> MapImage:
        """Return rows from the top, ``last`` excluded; ``InvalidMap`` if a pixel of them cannot be."""
        pixels = self._source.rows(first, last)
        return MapImage(pixels if pixels.ndim == 3 else pixels[..., np.newaxis])

    def check(self) -> None:
        """Raise ``InvalidMap`` if any pixel cannot be."""
        self._source.check()


def open_image(image: Buffer) -> ImageRows:
    """Read what a PGM or PNG file says of itself; the two are told apart by how it begins, as map_server does.

    A PNG, or a PGM in text, is decoded; of a binary PGM nothing is read before it is asked for.

    Raises
    ------
    InvalidMap
        Neither of the two, or broken.
    """
    begin = image[: len(PNG)]
    if begin == PNG:
        return ImageRows(open_png(image))
    if begin.startswith(PGM):
        return ImageRows(open_pgm(image))
    raise InvalidMap(f"the map's image is neither PGM (P2, P5) nor PNG: it begins with {image[:12]!r}; convert it")


def media_type(image: Buffer) -> str:
    """Return what HTTP calls such a file."""
    return "image/png" if image[: len(PNG)] == PNG else "image/x-portable-graymap"
