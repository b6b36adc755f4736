"""Headers of netpbm's images as programs write them.

The kind, and its members: line ends of Windows, whose second byte is no pixel; comments after the last number, before
the pixels; several white spaces there; a line end after the pixels; magic numbers of all six formats.
"""

import pytest

from ppaas.errors import InvalidMap
from ppaas.maps.formats.netpbm import MAX_HEADER, binary_pixels, read_header
from tests.support.hostile_bytes import peak_memory

PIXELS = b"\x0a\x0d\x23\x20"
"""Pixels that are white space and the sign of a comment."""


def pixels(image: bytes, size: int = 4) -> bytes:
    return bytes(binary_pixels(image, read_header(image), size, 1))


@pytest.mark.parametrize(
    "header",
    [
        b"P5\n2 2\n255\n",
        b"P5\r\n2 2\r\n255\r\n",
        b"P5\r\n# CREATOR: a program of Windows\r\n2\r\n2\r\n255\r\n",
        b"P5\n2 2\n255\r",
        b"P5 2 2 255 ",
    ],
)
@pytest.mark.parametrize("end", [b"", b"\n", b"\r\n"])
def test_pixels_begin_after_the_line_end_of_the_header(header, end):
    if header.endswith(b"\r") and end:
        end = b""
    assert pixels(header + PIXELS + end) == PIXELS


@pytest.mark.parametrize("gap", [b" \n", b" \r\n", b"\t\n", b"\n# made by hand\n", b" # made\r\n# by hand\r\n"])
def test_comments_and_white_space_before_the_pixels_are_skipped_if_they_are_not_pixels(gap):
    assert pixels(b"P5\n2 2\n255" + gap + b"\x01\x02\x03\x04") == b"\x01\x02\x03\x04"


def test_a_file_without_surplus_has_only_pixels():
    assert pixels(b"P5\n2 2\n255\n#a\n\x04") == b"#a\n\x04"
    assert pixels(b"P5\n2 2\n255\r\n\x01\x02\x03") == b"\n\x01\x02\x03"


@pytest.mark.parametrize("more", [b"\x01", b"# no pixels\n" * 1000 + b"\x01"])
def test_other_surplus_is_refused(more):
    with pytest.raises(InvalidMap, match="follow the 2×2 pixels of the PGM"):
        pixels(b"P5\n2 2\n255\n" + PIXELS[::-1] + more)


@pytest.mark.parametrize(
    ("image", "header"),
    [
        (b"P1 2 3 ", ("PBM", True, 2, 3, 1, 1)),
        (b"P2 2 3 255\n", ("PGM", True, 2, 3, 255, 1)),
        (b"P3 2 3 255\n", ("PPM", True, 2, 3, 255, 3)),
        (b"P4 2 3\n", ("PBM", False, 2, 3, 1, 1)),
        (b"P5 2 3 65535\n", ("PGM", False, 2, 3, 65535, 1)),
        (b"P6 2 3 15\n", ("PPM", False, 2, 3, 15, 3)),
    ],
)
def test_the_first_two_bytes_are_the_format(image, header):
    found = read_header(image)
    assert (found.name, found.is_text, found.width, found.height, found.maximum, found.channels) == header
    assert found.end == len(image)


@pytest.mark.parametrize("image", [b"", b"P0 1 1 255 ", b"P7\nWIDTH 1\n", b"p5 1 1 255 ", b" P5 1 1 255 "])
def test_other_first_bytes_are_refused(image):
    with pytest.raises(InvalidMap, match="not a PGM image"):
        read_header(image)


@pytest.mark.parametrize("kind", [b"P1", b"P2", b"P3", b"P4", b"P5", b"P6"])
@pytest.mark.parametrize("gap", [b" ", b"#\n", b"#" + b"a" * 98 + b"\n"])
def test_a_header_that_does_not_end_takes_no_memory(kind, gap):
    image = kind + gap * (MAX_HEADER * 20 // len(gap)) + b"1 1 1 \0\0\0"

    def read():
        with pytest.raises(InvalidMap):
            read_header(image)

    assert peak_memory(read) < 200 * MAX_HEADER
    assert read_header(kind + gap * ((MAX_HEADER - 20) // len(gap)) + b"1 1 1 ").width == 1
