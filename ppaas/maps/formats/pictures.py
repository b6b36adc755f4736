"""Images in formats of drawing programs and cameras: BMP, JPEG, and TIFF without compression.

Compressed TIFF would be decoded by libtiff, which writes what it finds to the process's stderr.
"""

import io
import warnings
from typing import TYPE_CHECKING

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.pillow_rows import ORIENTATION, PillowRows, check_size, check_upright, pillow_errors

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

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
