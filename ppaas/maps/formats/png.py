"""Reader of PNG images; their checksums are verified."""

import io

from ppaas.maps.buffer import Buffer
from ppaas.maps.formats.pillow_rows import PillowRows, check_size, pillow_errors

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
    # Imported here, since only PNG maps need Pillow.
    from PIL.PngImagePlugin import PngImageFile  # noqa: PLC0415

    with pillow_errors(_NAME):
        checked = PngImageFile(io.BytesIO(image))
        check_size(_NAME, *checked.size)
        checked.verify()  # checksums, which decoding ignores
        return PillowRows(PngImageFile(io.BytesIO(image)), _NAME)
