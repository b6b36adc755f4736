"""Reader of PNG images; their checksums are verified."""

import io
import struct
from typing import TYPE_CHECKING

from ppaas.errors import InvalidMap
from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.pillow_rows import ORIENTATION, PillowRows, check_size, check_upright, pillow_errors

if TYPE_CHECKING:
    from PIL.PngImagePlugin import PngImageFile

MAGIC = b"\x89PNG\r\n\x1a\n"

MAX_CHUNKS = 1 << 16
"""Largest number of chunks; libpng writes one for 8 KiB of pixels."""

MAX_OTHERS = 1000
"""Largest number of chunks without pixels."""

_NAME = "PNG"
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
    with pillow_errors(_NAME):
        _opened(data).verify()  # checksums, which decoding ignores; Pillow then has to open the file again
        file = _opened(data)
        rows = PillowRows(file, _NAME)
        check_upright(_NAME, file.getexif().get(ORIENTATION))
        return rows


def png_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width in the header of a PNG file; ``InvalidMap`` if it is broken or too large."""
    data = image[: len(image)]
    check_chunks(data)
    with pillow_errors(_NAME):
        width, height = _opened(data).size
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


def _opened(data: bytes) -> "PngImageFile":
    """Return the file with its header read, and checked before memory is allocated for the pixels."""
    # Imported here, since only PNG maps need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    file = PngImageFile(io.BytesIO(data))
    check_size(_NAME, *file.size)
    return file
