"""Reader of PNG images; their checksums are verified."""

import io
from typing import TYPE_CHECKING

from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.pillow_rows import PillowRows, check_size, pillow_errors

if TYPE_CHECKING:
    from PIL.PngImagePlugin import PngImageFile

MAGIC = b"\x89PNG\r\n\x1a\n"

_NAME = "PNG"


def open_png(image: Buffer) -> PillowRows:
    """Read a PNG of any kind: grey, RGB or palette, 1 to 16 bits per sample, with or without alpha.

    Parameters
    ----------
    image : bytes or mmap
        The whole file.

    Raises
    ------
    InvalidMap
        The file is broken or truncated, has a wrong checksum, or is too large.
    """
    with pillow_errors(_NAME):
        _opened(image).verify()  # checksums, which decoding ignores
        return PillowRows(_opened(image), _NAME)


def png_size(image: Buffer) -> tuple[int, int]:
    """Return the height and width in the header of a PNG file; ``InvalidMap`` if it is broken or too large."""
    with pillow_errors(_NAME):
        width, height = _opened(image).size
        return height, width


def _opened(image: Buffer) -> "PngImageFile":
    """Return the file with its header read, and checked before memory is allocated for the pixels."""
    # Imported here, since only PNG maps need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    file = PngImageFile(io.BytesIO(image))
    check_size(_NAME, *file.size)
    return file
