"""Depth images in RVL are decoded as the slow twin decodes them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.perception.kernels import rvl as kernels
from tests.reference.perception import rvl as twin

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
