"""PBM images, binary and text, good and bad."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.errors import InvalidMap
from ppaas.maps.formats import netpbm
from ppaas.maps.formats.netpbm import open_pbm
from tests.support.world.maps import sides


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
def test_an_invalid_image_is_refused_with_the_reason(image, reason):
    with pytest.raises(InvalidMap, match=reason):
        parse(image)


@given(st.binary(max_size=60))
def test_arbitrary_bytes_are_read_or_raise_invalid_map(rubbish):
    for image in (b"P4 " + rubbish, b"P4 2 2 " + rubbish, b"P1 2 2 " + rubbish):
        try:
            assert parse(image).dtype == np.uint8
        except InvalidMap as error:
            assert str(error)
