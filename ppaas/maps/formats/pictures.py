"""Images that Pillow decodes, a widely reviewed library: PNG with verified checksums, BMP, JPEG, uncompressed TIFF.

Of images with 16 bits per sample, the upper 8 bits are used, as SDL_image passes them to map_server. Compressed TIFF is
refused: it would be decoded by libtiff, which writes what it finds to the process's stderr.
"""

import io
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFile import ImageFile
    from PIL.PngImagePlugin import PngImageFile


# -- rows of an image --------------------------------------------------------------------------------------------------

MAX_PIXELS = 1 << 26
"""Limit of the number of pixels, since a small file can decompress to any number of them."""

BROKEN = (OSError, SyntaxError, ValueError, KeyError, IndexError, TypeError, EOFError, struct.error, zlib.error)
"""Errors that Pillow raises for broken files."""

ORIENTATION = 274
"""Tag of TIFF and EXIF."""

_TURNED = range(2, 9)
"""Values of the tag of images whose first row is not their top, or that are mirrored."""

_GREY = ("1", "L")
_DEEP_GREY = ("I;16", "I;16L", "I;16B", "I;16N")
_TOO_DEEP = ("I", "F")
_WITH_ALPHA = ("LA", "PA", "La", "RGBA", "RGBa")


class PillowRows:
    """Decoded image, whose rows are converted to arrays on demand.

    Parameters
    ----------
    file : ImageFile
        The image, opened by Pillow.
    name : str
        Name of the format, for errors.

    Raises
    ------
    InvalidMap
        The image cannot be decoded, or has 32 bits per sample.
    """

    def __init__(self, file: "ImageFile", name: str) -> None:
        self._file = file
        self._name = name
        with pillow_errors(name):
            file.load()
            if file.mode == "P" and file.palette is None:
                raise ValueError("its palette is missing")
            if file.mode in _TOO_DEEP:
                raise ValueError("it has 32 bits per sample, of which map_server and Nav2 read none")

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width)."""
        width, height = self._file.size
        return height, width

    def rows(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows as (last − first, width, n) array: grey (n = 1), red, green, blue (3), or these and alpha (4)."""
        with pillow_errors(self._name):
            return _pixels(self._file.crop((0, first, self._file.width, last)), self._file.info.get("transparency"))

    def check(self) -> None:
        """Do nothing, since the image has been decoded completely."""


def check_upright(name: str, orientation: object) -> None:
    """Raise ``InvalidMap`` for an orientation by which viewers turn an image, since readers of maps disagree on it."""
    if orientation in _TURNED:
        raise InvalidMap(f"the {name} is turned (orientation {orientation}): save the map's image upright")


@contextmanager
def pillow_errors(name: str) -> Iterator[None]:
    """Raise Pillow's errors for broken files as ``InvalidMap``; ``name`` is the format's name."""
    try:
        yield
    except BROKEN as error:
        raise InvalidMap(f"the {name} cannot be read: {error}; save the map's image again") from error


def check_size(name: str, width: int, height: int) -> None:
    """Raise ``InvalidMap`` if an image has no or more than `MAX_PIXELS` pixels."""
    if not 1 <= width * height <= MAX_PIXELS:
        raise InvalidMap(
            f"the {name} has {width}×{height} pixels; a map's {name} must have from 1 to {MAX_PIXELS} pixels"
        )


def _pixels(image: "Image", transparent: object) -> NDArray[np.uint8]:
    """Return the pixels of an image; ``transparent`` is the colour or palette entry without opacity, if any."""
    if image.mode in _DEEP_GREY:
        grey = np.asarray(image)
        high = (grey >> 8).astype(np.uint8)
        if transparent is None:
            return high[..., np.newaxis]
        alpha = np.where(grey == transparent, 0, 255).astype(np.uint8)
        return np.stack((high, high, high, alpha), axis=-1)
    if transparent is None and image.mode in _GREY:
        return np.asarray(image.convert("L"))[..., np.newaxis]
    opaque = transparent is None and image.mode not in _WITH_ALPHA
    return np.asarray(image.convert("RGB" if opaque else "RGBA"))


# -- BMP, JPEG and TIFF ------------------------------------------------------------------------------------------------

MAX_SCANS = 64
"""Largest number of scans of a progressive JPEG; each is decoded over the whole image."""

_SCAN = b"\xff\xda"


def open_picture(image: Buffer, name: str) -> PillowRows:
    """Read an image.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.
    name : str
        Name of its format: ``BMP``, ``JPEG`` or ``TIFF``.

    Raises
    ------
    InvalidMap
        The file is broken or truncated, it is too large, it is turned, or it is a compressed TIFF.
    """
    data = image[: len(image)]
    if name == "JPEG" and data.count(_SCAN) > MAX_SCANS:
        raise InvalidMap(f"the JPEG has more than {MAX_SCANS} scans: save the map's image again, not progressively")
    with pillow_errors(name):
        return PillowRows(_opened(data, name), name)


def picture_size(image: Buffer, name: str) -> tuple[int, int]:
    """Return the height and width in the header of an image; raises as ``open_picture``."""
    with pillow_errors(name):
        width, height = _opened(image[: len(image)], name).size
        return height, width


def _opened(data: bytes, name: str) -> "ImageFile":
    """Return the file with its header read, and checked before memory is allocated for the pixels."""
    warnings.filterwarnings("ignore", module=r"PIL\.")  # about faults in a file, which matter only if it cannot be read
    file = _reader(name)(io.BytesIO(data))
    check_size(name, *file.size)
    if name == "TIFF" and file.info.get("compression") != "raw":
        raise InvalidMap("the TIFF is compressed: save the map's image without compression, or as PNG")
    if name == "TIFF":
        check_upright(name, file.tag_v2.get(ORIENTATION))  # type: ignore[attr-defined]
    if name == "JPEG":
        check_upright(name, file.getexif().get(ORIENTATION))
    return file


def _reader(name: str) -> "type[ImageFile]":
    """Return Pillow's reader of a format. ``Image.open`` would try others, and warn of sizes that are allowed here."""
    # Imported here, since only these maps need Pillow.
    from PIL.BmpImagePlugin import BmpImageFile  # noqa: PLC0415
    from PIL.JpegImagePlugin import JpegImageFile  # noqa: PLC0415
    from PIL.TiffImagePlugin import TiffImageFile  # noqa: PLC0415

    return {"BMP": BmpImageFile, "JPEG": JpegImageFile, "TIFF": TiffImageFile}[name]


# -- PNG ---------------------------------------------------------------------------------------------------------------

MAGIC = b"\x89PNG\r\n\x1a\n"

MAX_CHUNKS = 1 << 16
"""Largest number of chunks; libpng writes one for 8 KiB of pixels."""

MAX_OTHERS = 1000
"""Largest number of chunks without pixels."""

_PNG = "PNG"
_CHUNK = struct.Struct(">I4s")
_REST = 12
"""Size of a chunk besides its content: length, kind and checksum [bytes]."""


def open_png(image: Buffer) -> PillowRows:
    """Read a PNG of any kind: grey, RGB or palette, 1 to 16 bits per sample, with or without alpha.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is broken or truncated, has a wrong checksum, is too large, or is turned by its EXIF.
    """
    data = image[: len(image)]
    check_chunks(data)
    with pillow_errors(_PNG):
        _opened_png(data).verify()  # checksums, which decoding ignores; Pillow then has to open the file again
        file = _opened_png(data)
        rows = PillowRows(file, _PNG)
        check_upright(_PNG, file.getexif().get(ORIENTATION))
        return rows


def png_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width in the header of a PNG file; ``InvalidMap`` if it is broken or too large."""
    data = image[: len(image)]
    check_chunks(data)
    with pillow_errors(_PNG):
        width, height = _opened_png(data).size
        return height, width


def check_chunks(image: Buffer) -> None:
    """Raise ``InvalidMap`` if a PNG has too many chunks, or more than one colour profile.

    Pillow unpacks each profile, and reads each chunk in Python.
    """
    at, chunks, others, profiles = len(MAGIC), 0, 0, 0
    while at + _REST <= len(image) and chunks <= MAX_CHUNKS:
        length, kind = _CHUNK.unpack_from(image, at)
        at += _REST + length
        chunks += 1
        others += kind != b"IDAT"
        profiles += kind == b"iCCP"
    if chunks > MAX_CHUNKS or others > MAX_OTHERS or profiles > 1:
        raise InvalidMap("the PNG has too many chunks: save the map's image again")


def _opened_png(data: bytes) -> "PngImageFile":
    """Return the file with its header read, and checked before memory is allocated for the pixels."""
    # Imported here, since only PNG maps need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    file = PngImageFile(io.BytesIO(data))
    check_size(_PNG, *file.size)
    return file
