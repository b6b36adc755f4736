"""Images of maps in any supported format. The first bytes of a file decide its format, as in map_server."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.netpbm import PbmRows, PgmRows, netpbm_size, open_pbm, open_pgm
from ppaas.maps.formats.pictures import MAGIC as PNG
from ppaas.maps.formats.pictures import PillowRows, open_picture, open_png, picture_size, png_size

_Rows = PgmRows | PbmRows | PillowRows


@dataclass(frozen=True, slots=True)
class ImageFormat:
    """Format of images.

    Parameters
    ----------
    name : str
        Its name.
    magic : tuple of bytes
        First bytes of its files.
    media_type : str
        Its type in HTTP.
    endings : tuple of str
        Endings of its file names, the usual one first.
    reader : callable
        Opens a file of the format.
    size : callable
        Returns the height and width in the header of a file [pixels].
    """

    name: str
    magic: tuple[bytes, ...]
    media_type: str
    endings: tuple[str, ...]
    reader: Callable[[Buffer], _Rows]
    size: Callable[[Buffer], tuple[int, int]]


def _picture(name: str, *magic: bytes, media_type: str, endings: tuple[str, ...]) -> ImageFormat:
    read, size = partial(open_picture, name=name), partial(picture_size, name=name)
    return ImageFormat(name, magic, media_type, endings, read, size)


FORMATS = (
    ImageFormat("PGM", (b"P2", b"P5"), "image/x-portable-graymap", (".pgm", ".pnm"), open_pgm, netpbm_size),
    ImageFormat("PNG", (PNG,), "image/png", (".png",), open_png, png_size),
    ImageFormat("PPM", (b"P3", b"P6"), "image/x-portable-pixmap", (".ppm",), open_pgm, netpbm_size),
    ImageFormat("PBM", (b"P1", b"P4"), "image/x-portable-bitmap", (".pbm",), open_pbm, netpbm_size),
    _picture("BMP", b"BM", media_type="image/bmp", endings=(".bmp",)),
    _picture("JPEG", b"\xff\xd8\xff", media_type="image/jpeg", endings=(".jpg", ".jpeg")),
    _picture("TIFF", b"II*\0", b"MM\0*", media_type="image/tiff", endings=(".tif", ".tiff")),
)
"""Formats that are read: what map_server and Nav2 read too."""

ENDINGS = tuple(ending for one in FORMATS for ending in one.endings)
"""Endings of the names of image files, in lower case."""


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
    source : PgmRows, PbmRows or PillowRows
        The opened file.

    Attributes
    ----------
    shape : tuple of int
        Height and width [pixels].
    check : callable
        Raises ``InvalidMap`` if any pixel is invalid.
    """

    def __init__(self, source: _Rows) -> None:
        self._source = source
        self.shape = source.shape
        self.check = source.check

    def rows(self, first: int, last: int) -> MapImage:
        """Return the rows ``first`` to ``last`` (excluded) from the top; ``InvalidMap`` for invalid pixels."""
        pixels = self._source.rows(first, last)
        return MapImage(pixels if pixels.ndim == 3 else pixels[..., np.newaxis])


def format_of(image: Buffer) -> ImageFormat:
    """Return the format of an image file.

    Raises
    ------
    InvalidMap
        It is none of `FORMATS`.
    """
    for one in FORMATS:
        if any(image[: len(magic)] == magic for magic in one.magic):
            return one
    names = ", ".join(one.name for one in FORMATS)
    raise InvalidMap(
        f"the map's image has none of the formats {names} (it begins with {image[:12]!r}): convert it to one of them"
    )


def open_image(image: Buffer) -> ImageRows:
    """Open an image file.

    The pixels of binary PGM, PPM and PBM are read on demand, pixels of other files are decoded at once.

    Raises
    ------
    InvalidMap
        The file has another format, or is broken.
    """
    return ImageRows(format_of(image).reader(image))


def image_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width of an image [pixels], for which only its header is read.

    Raises
    ------
    InvalidMap
        The file has another format, or its header is broken.
    """
    return format_of(image).size(image)


def media_type(image: Buffer) -> str:
    """Return the media type of an image file for HTTP; ``InvalidMap`` if it has another format."""
    return format_of(image).media_type
