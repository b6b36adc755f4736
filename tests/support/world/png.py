"""PNG files written byte by byte, so that tests do not depend on a library's encoder."""

import struct
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"
GREY, RGB, PALETTE, GREY_ALPHA, RGBA = 0, 2, 3, 4, 6


def chunk(kind: bytes, data: bytes = b"") -> bytes:
    """Return one chunk with its length and checksum."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def header(width: int, height: int, depth: int = 8, colour: int = GREY) -> bytes:
    """Return signature and first chunk."""
    return SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0))


def png(rows: list[bytes], width: int, depth: int = 8, colour: int = GREY, before: bytes = b"") -> bytes:
    """Return a file of rows of packed samples, from the top; ``before`` are chunks such as a palette."""
    data = zlib.compress(b"".join(b"\0" + row for row in rows))
    return header(width, len(rows), depth, colour) + before + chunk(b"IDAT", data) + chunk(b"IEND")
