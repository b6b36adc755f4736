"""Depth images as PNG and back."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ppaas.errors import InvalidInput
from ppaas.perception.compressed_depth import FORMATS, compress, decompress
from ppaas.perception.kernels import rvl as kernels
from tests.reference.perception import rvl as twin


@given(arrays.arrays(np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 9))))
def test_millimetres_round_trip(image):
    kind, data = compress(image)
    assert kind == FORMATS["uint16"]
    assert np.array_equal(decompress(kind, data), image)


@given(arrays.arrays(np.float32, (4, 5), elements=st.floats(0.25, 10.0, width=32)))
def test_metres_round_trip_more_finely_at_short_range(image):
    kind, data = compress(image)
    back = decompress(kind, data)
    assert back.dtype == np.float32
    # Half a step of the inverse depth, of which there are 10,100.
    assert (np.abs(back - image) <= image**2 / 10_100 * 0.51 + 1e-5).all()


def test_unknown_and_far_depths_become_nan():
    image = np.array([[0.0, np.nan, np.inf, 11.0, 0.1, 1.0]], np.float32)
    back = decompress(*compress(image))
    assert np.isnan(back[0, :5]).all()
    assert back[0, 5] == pytest.approx(1.0, abs=1e-4)


def test_image_of_a_room_is_compressed_to_a_fifth():
    rows, columns = np.mgrid[:480, :640]
    image = (2000 + 3 * columns + 500 * (rows > 240)).astype(np.uint16)
    assert len(compress(image)[1]) < image.nbytes / 5


@pytest.mark.parametrize(
    "kind", ["16UC1; compressedDepth", "16UC1", "16UC1;compressedDepth png", "mono16; compressedDepth"]
)
def test_formats_without_a_codec_are_png(kind):
    image = np.arange(12, dtype=np.uint16).reshape(3, 4) * 100
    assert np.array_equal(decompress(kind, compress(image)[1]), image)


@pytest.mark.parametrize("kind", ["16UC1; png compressed ", "16UC1; compressedDepth png", "mono16; png compressed"])
def test_png_without_a_header_is_that_of_the_transport_compressed(kind):
    image = np.arange(12, dtype=np.uint16).reshape(3, 4) * 100
    png = compress(image)[1][12:]
    assert np.array_equal(decompress(kind, png), image)
    with pytest.raises(InvalidInput, match="in metres needs the header"):
        decompress("32FC1; png compressed", png)


@pytest.mark.parametrize("kind", ["32FC1; compressedDepth", "32FC1"])
def test_metres_of_early_versions_are_read(kind):
    image = np.array([[1.0, 2.0], [4.0, 8.0]], np.float32)
    assert decompress(kind, compress(image)[1]) == pytest.approx(image, abs=0.01)


def rvl(pixels: np.ndarray, head: bytes = struct.pack("<iff", 0, 0.0, 0.0)) -> bytes:
    height, width = pixels.shape
    return head + struct.pack("<II", width, height) + twin.encode(pixels.ravel().tolist())


@given(arrays.arrays(np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 9))))
def test_millimetres_in_rvl_are_read(image):
    assert np.array_equal(decompress("16UC1; compressedDepth rvl", rvl(image)), image)


def test_metres_in_rvl_are_those_of_png():
    image = np.array([[0.5, np.nan, 2.0], [4.0, 9.0, 0.25]], np.float32)
    kind, png = compress(image)
    quantized = decompress(FORMATS["uint16"], png)
    assert np.array_equal(
        decompress("32FC1; compressedDepth rvl", rvl(quantized, png[:12])), decompress(kind, png), equal_nan=True
    )


@pytest.mark.parametrize(
    ("kind", "data", "why"),
    [
        ("jpeg", b"", "'jpeg'"),
        ("16UC1; compressedDepth jpeg", b"\0" * 40, "not '16UC1; compressedDepth jpeg'"),
        ("rgb8; jpeg compressed bgr8", b"\0" * 40, "not 'rgb8; jpeg compressed bgr8'"),
        ("16UC1; compressedDepth rvl", b"\0" * 14, "as RVL: it has 0×0 pixels"),
        (
            "16UC1; compressedDepth rvl",
            b"\0" * 12 + struct.pack("<II", 1 << 20, 1 << 20),
            "as RVL: it has 1048576×1048576",
        ),
        ("16UC1; compressedDepth rvl", rvl(np.ones((3, 4), np.uint16))[:-4], "as RVL: it ends after 5 of 12 pixels"),
        (FORMATS["uint16"], b"\0" * 12, "12 bytes"),
        (FORMATS["uint16"], b"\0" * 40, "cannot be read"),
        (FORMATS["uint16"], compress(np.zeros((40, 40), np.uint16))[1][:-40], "cannot be read"),
        (FORMATS["float32"], struct.pack("<iff", 1, 1.0, 1.0) + b"\x89PNG\r\n\x1a\n", "cannot be read"),
    ],
)
def test_an_invalid_depth_image_is_refused(kind, data, why):
    with pytest.raises(InvalidInput, match=why):
        decompress(kind, data)


ENCODED = compress((np.arange(600, dtype=np.uint16) * 77).reshape(20, 30))[1]


@given(st.integers(0, len(ENCODED) - 1), st.binary(min_size=1, max_size=8))
def test_corrupt_image_is_refused_or_decoded(where, garbage):
    broken = ENCODED[:where] + garbage + ENCODED[where + len(garbage) :]
    try:
        image = decompress(FORMATS["uint16"], broken)
    except InvalidInput:
        return
    assert image.dtype == np.uint16 and image.ndim == 2


depths = st.one_of(st.just(0), st.integers(0, 65535), st.integers(900, 1100))


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    kernels.warm()


def expand(code: bytes, count: int) -> list[int]:
    pixels = np.zeros(count, np.uint16)
    found = kernels.expand_rvl(np.frombuffer(code[: len(code) // 4 * 4], "<u4"), pixels)
    return pixels[:found].tolist()


@given(st.lists(depths, min_size=1, max_size=200))
def test_code_of_depths_is_decoded(pixels: list[int]) -> None:
    code = twin.encode(pixels)
    assert twin.decode(code, len(pixels)) == pixels
    assert expand(code, len(pixels)) == pixels


@given(st.lists(depths, min_size=1, max_size=100), st.integers(0, 60), st.integers(1, 120))
def test_code_that_is_cut_gives_the_depths_before_the_cut(pixels: list[int], words: int, count: int) -> None:
    code = twin.encode(pixels)[: 4 * words]
    assert expand(code, count) == twin.decode(code, count)


@given(st.binary(max_size=200), st.integers(1, 100))
def test_any_bytes_are_decoded_like_the_twin_decodes_them(code: bytes, count: int) -> None:
    assert expand(code, count) == twin.decode(code, count)


def test_the_layout_is_that_of_the_codec() -> None:
    """Two zeros, one depth of 5: numbers 2, 1, 10, which are the nibbles 2, 1, 2 + 8, 1 from the highest bits on."""
    assert twin.encode([0, 0, 5]) == (0x21A10000).to_bytes(4, "little")
    assert expand((0x21A10000).to_bytes(4, "little"), 3) == [0, 0, 5]
