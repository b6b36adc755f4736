"""Images of maps in any supported format (PGM, PNG)."""

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
    """Image of a map.

    Parameters
    ----------
    channels : (height, width, n) uint8 array
        Grey (n = 1); red, green, blue (3); or these and alpha (4), 0 transparent to 255 opaque. Row 0 is the top.
    """

    channels: NDArray[np.uint8]

    @property
    def alpha(self) -> NDArray[np.uint8] | None:
        """Opacity of each pixel, (height, width), 0 to 255; None if the image has no alpha channel."""
        return self.channels[..., 3] if self.channels.shape[2] == 4 else None


class ImageRows:
    """Image whose rows are read on demand.

    Parameters
    ----------
    source : PgmRows or PngRows
        The opened file.

    Attributes
    ----------
    shape : tuple of int
        Height and width [pixels].
    check : callable
        Raises ``InvalidMap`` if any pixel is invalid.
    """

    def __init__(self, source: PgmRows | PngRows) -> None:
        self._source = source
        self.shape = source.shape
        self.check = source.check

    def rows(self, first: int, last: int) -> MapImage:
        """Return the rows ``first`` to ``last`` (excluded) from the top; ``InvalidMap`` for invalid pixels."""
        pixels = self._source.rows(first, last)
        return MapImage(pixels if pixels.ndim == 3 else pixels[..., np.newaxis])


def open_image(image: Buffer) -> ImageRows:
    """Open a PGM or PNG file; its first bytes decide which of the two it is, as in map_server.

    A PNG or a PGM in text is decoded at once; the pixels of a binary PGM are read on demand.

    Raises
    ------
    InvalidMap
        The file has another format, or is broken.
    """
    begin = image[: len(PNG)]
    if begin == PNG:
        return ImageRows(open_png(image))
    if begin.startswith(PGM):
        return ImageRows(open_pgm(image))
    raise InvalidMap(
        f"the map's image is neither PGM (P2, P5) nor PNG (it begins with {image[:12]!r}): convert it to one of them"
    )


def media_type(image: Buffer) -> str:
    """Return the media type of an image file for HTTP."""
    return "image/png" if image[: len(PNG)] == PNG else "image/x-portable-graymap"
