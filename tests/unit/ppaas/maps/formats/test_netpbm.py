"""Images of netpbm, binary and text, good and bad: PBM, PGM and PPM, and their headers as programs write them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.errors import InvalidMap
from ppaas.maps.formats import netpbm
from ppaas.maps.formats.netpbm import MAX_HEADER, binary_pixels, open_pbm, open_pgm, read_header, write_pgm
from tests.support.hostile_bytes import peak_memory
from tests.support.world.maps import sides

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


def parse(image):
    opened = open_pbm(image)
    opened.check()
    return opened.rows(0, opened.shape[0])


@pytest.mark.parametrize(
    "image",
    [
        b"P4 3 2 \xa0\x40",
        b"P4\r\n# drawn\r\n3 2\r\n\xa0\x40",
        b"P4\n3 2\n\xbf\x5f\n",  # bits after the last pixel of a row mean nothing
        b"P1 3 2 1 0 1 0 1 0",
        b"P1\n3 2\n101\n010\n",
        b"P1\r\n# drawn\r\n3 2\r\n10 1\t0 # more\r\n10\r\n",
        b"P1 3 2#\n101010",
    ],
)
def test_one_is_black_and_nought_is_white(image):
    assert parse(image).tolist() == [[0, 255, 0], [255, 0, 255]]


@given(hnp.arrays(np.bool_, sides(20)), st.integers(1, 40))
def test_text_and_binary_images_are_equal_for_any_block_size(black, block):
    size = b"%d %d\n" % black.shape[::-1]
    text = b"".join(b"1" if bit else b"0" for bit in black.ravel())
    expected = np.where(black, 0, 255)
    assert np.array_equal(parse(b"P4 " + size + np.packbits(black, axis=1).tobytes()), expected)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(netpbm, "BLOCK", block)
        assert np.array_equal(parse(b"P1 " + size + text), expected)


@given(hnp.arrays(np.bool_, sides(20)), st.data())
def test_single_rows_equal_rows_of_the_whole_image(black, data):
    image = b"P4 %d %d\n" % black.shape[::-1] + np.packbits(black, axis=1).tobytes()
    first = data.draw(st.integers(0, len(black) - 1))
    assert np.array_equal(open_pbm(image).rows(first, first + 1), parse(image)[first : first + 1])


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (b"P4", "not a PBM"),
        (b"P4 3 ", "not a PBM"),
        (b"P4 9 2 \x00\x00\x00", "the PBM is truncated: 1 of its 9×2 pixels are missing"),
        (b"P4 8 1 \x00\x01", "1 bytes follow"),
        (b"P4 0 8 ", "0×8"),
        (b"P4 99999 99999 ", "1073741824 cells"),
        (b"P1 3 1 10", "1 of its 3×1 pixels are missing"),
        (b"P1 3 1 10 ", "1 of its 3×1 pixels are missing"),
        (b"P1 3 1 1012", "b'2' among the pixels of the PBM"),
        (b"P1 3 1 1010", "1 numbers follow"),
        (b"P1 16384 16384 1", "at least 268435455"),
        (b"P4 16384 16385 ", "at most 268435456 pixels"),
    ],
)
def test_an_invalid_pbm_is_refused_with_the_reason(image, reason):
    with pytest.raises(InvalidMap, match=reason):
        parse(image)


@given(st.binary(max_size=60))
def test_arbitrary_bytes_after_a_pbm_header_are_read_or_raise_invalid_map(rubbish):
    for image in (b"P4 " + rubbish, b"P4 2 2 " + rubbish, b"P1 2 2 " + rubbish):
        try:
            assert parse(image).dtype == np.uint8
        except InvalidMap as error:
            assert str(error)


def pixels_of(image):
    """Return all pixels of an image."""
    opened = open_pgm(image)
    return opened.rows(0, opened.shape[0])


@given(hnp.arrays(np.uint8, sides(20)))
def test_pixels_round_trip(pixels):
    assert np.array_equal(pixels_of(write_pgm(pixels)), pixels)


@pytest.mark.parametrize(
    "header",
    [
        b"P5 2 2 255\n",
        b"P5\n2\n2\n255\n",
        b"P5\t2\r\n2 255 ",
        b"P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n2 2\n255\n",
        b"P5# a\n#b # c\n 2# width\n# \xff\n2\n#d\n255\n",
    ],
)
def test_white_space_and_comments_are_accepted_between_header_fields(header):
    assert pixels_of(header + b"\x00\x0a\x23\xff").tolist() == [[0, 10], [35, 255]]


def test_first_row_of_the_file_is_row_0():
    assert pixels_of(b"P5 1 2 255 \x01\x02").tolist() == [[1], [2]]


def test_a_smaller_maximum_is_scaled_to_255():
    assert pixels_of(b"P5 3 1 100 \x00\x32\x64").tolist() == [[0, 127, 255]]


def test_sixteen_bits_are_read_high_byte_first_and_scaled_down():
    assert pixels_of(b"P5 4 1 65535 \x00\xff\x01\x01\x80\x00\xff\xff").tolist() == [[0, 1, 127, 255]]
    assert pixels_of(b"P5 2 1 256 \x01\x00\x00\x80").tolist() == [[255, 127]]


@pytest.mark.parametrize(
    "image",
    [
        b"P2 2 2 255 0 10 35 255",
        b"P2\n# CREATOR: GIMP\n2 2\n255\n0\n10\n35\n255\n",
        b"P2 2 2 255\r\n000 10\t35 # the last\n255#\n",
        b"P2 2 2 510\n0 20 70 510",
        b"P2 2 2 65535\n0 2570 8995 65535",
    ],
)
def test_text_format_is_read_like_binary(image):
    assert pixels_of(image).tolist() == [[0, 10], [35, 255]]


@pytest.mark.parametrize(
    "image",
    [
        b"P6 2 1 255 \x00\x0a\x23\xff\x01\x02",
        b"P6\r\n# GIMP\r\n2 1\r\n255\r\n\x00\x0a\x23\xff\x01\x02",
        b"P3 2 1 255 0 10 35 255 1 2",
        b"P6 2 1 65535 \x00\x00\x0a\x0a\x23\x23\xff\xff\x01\x01\x02\x02",
    ],
)
def test_colours_are_the_third_axis(image):
    assert pixels_of(image).tolist() == [[[0, 10, 35], [255, 1, 2]]]


@given(hnp.arrays(np.uint8, sides(20)))
def test_text_and_binary_images_are_equal(pixels):
    text = " ".join(map(str, pixels.ravel().tolist())).encode()
    assert np.array_equal(pixels_of(b"P2 %d %d 255\n" % pixels.shape[::-1] + text), pixels)


def test_white_space_after_the_pixels_is_ignored():
    assert pixels_of(b"P5 1 1 255 \x07\r\n").tolist() == [[7]]


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (b"", "not a PGM"),
        (b"P5", "not a PGM"),
        (b"P2 2 1 255 7", "1 of its 2×1 pixels are missing"),
        (b"P2 1 1 255\n", "1 of its 1×1 pixels are missing"),
        (b"P2 1 1 255 7 8", "1 numbers follow"),
        (b"P2 1 1 255 -7", "b'-' among the pixels"),
        (b"P2 1 1 255 7.5", "among the pixels"),
        (b"P2 1 1 255 1e2", "among the pixels"),
        (b"P2 1 1 255 0000007", "at most five digits"),
        (b"P2 1 1 100 101", "101, above its maximum grey of 100"),
        (b"P2 32768 32768 255 7", "missing"),
        (b"P6 1 1 255 77", "the PPM is truncated: 1 of its 1×1 pixels are missing"),
        (b"P6 2 1 255 777", "1 of its 2×1 pixels are missing"),
        (b"P6 1 1 100 77e", "the PPM has a pixel of 101"),
        (b"P3 2 1 255 7 7 7 7 7", "1 of its 2×1 pixels are missing"),
        (b"P3 1 1 255 7 7 7 7", "1 numbers follow the 1×1 pixels of the PPM"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"P5 -1 1 255 \x00", "not a PGM"),
        (b"P5 1.5 1 255 \x00", "not a PGM"),
        (b"P5 99999999999999999999 1 255 \x00", "not a PGM"),
        (b"P5 # 1 1 255 \x00", "not a PGM"),
        (b"P5 0 5 255 ", "0×5"),
        (b"P5 5 0 255 ", "5×0"),
        (b"P5 32769 32769 255 ", "32769×32769"),
        (b"P5 9999999999 9999999999 255 ", "1073741824 cells"),
        (b"P5 1 1 0 \x00", "maximum grey must be from 1 to 65535, not 0"),
        (b"P5 1 1 65536 \x00\x00", "maximum grey must be from 1 to 65535, not 65536"),
        (b"P5 2 1 65535 \x00\x00\x00", "1 of its 2×1 pixels are missing"),
        (b"P5 1 1 1000 \x03\xe9", "1001, above its maximum grey of 1000"),
        (b"P5 2 2 255 \x00\x00\x00", "1 of its 2×2 pixels are missing"),
        (b"P5 32768 32768 255 ", "truncated"),
        (b"P5 1 1 255 \x00\x01", "1 bytes follow"),
        (b"P5 1 1 100 \x65", "101, above its maximum grey of 100"),
    ],
)
def test_an_invalid_pgm_is_refused_with_the_reason(image, reason):
    with pytest.raises(InvalidMap, match=reason):
        pixels_of(image)


@given(st.binary(max_size=60))
def test_arbitrary_bytes_after_a_pgm_header_are_read_or_raise_invalid_map(rubbish):
    for image in (rubbish, b"P5 " + rubbish, b"P5 2 2 255 " + rubbish, b"P2 2 2 65535\n" + rubbish, b"P6 " + rubbish):
        try:
            assert pixels_of(image).dtype == np.uint8
        except InvalidMap as error:
            assert str(error)


@pytest.mark.parametrize("pixels", [np.zeros((2, 2), np.int8), np.zeros(4, np.uint8), np.zeros((0, 4), np.uint8)])
def test_only_rows_of_bytes_are_written(pixels):
    with pytest.raises(InvalidMap, match="uint8 pixels"):
        write_pgm(pixels)


def test_every_real_image_is_read(data):
    images = sorted((data / "ros").glob("*.pgm"))
    assert images
    assert all(pixels_of(image.read_bytes()).size > 100_000 for image in images)


gaps = st.sampled_from([b" ", b"\n", b"\r\n", b"\t ", b" # 7 8\n", b"#9\r", b"\n#\n#5\n"])


@given(st.lists(st.tuples(st.integers(0, 65535), gaps), min_size=1, max_size=30), st.integers(1, 40))
def test_text_is_parsed_alike_for_any_block_size(numbers, block):
    text = b"".join(b"%d%b" % pair for pair in numbers)
    image = b"P2 %d 1 65535\n" % len(numbers) + text
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(netpbm, "BLOCK", block)
        assert open_pgm(image).stored.tolist() == [[number for number, _ in numbers]]
