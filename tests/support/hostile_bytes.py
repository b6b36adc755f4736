"""Hostile bytes: mutations of good files, and a meter of the work that a parser does with them."""

import sys
import tracemalloc
from collections.abc import Callable, Sequence
from types import FrameType

from hypothesis import strategies as st

TOKENS = (
    b"\0", b"\xff", b"\n", b"\r\n", b"\t", b" " * 40, b"{", b"}", b"[" * 40, b"]", b'"', b"\\", b"\\ud800", b":", b"- ",
    b"&a ", b"*a", b"<<: ", b"<a>", b"</", b"<!DOCTYPE x>", b"&#0;", b"${x}", b"1e999", b"-1", b"9" * 40, b"NaN", b"#",
    b"--", b"\xed\xa0\x80", b"\xf0\x9f\xa4\x96", b"\x80\0\0\0", b"\x7f\xff\xff\xff",
)  # fmt: skip
"""Pieces that mean something to one parser or another."""


def mutations(seeds: Sequence[bytes]) -> st.SearchStrategy[bytes]:
    """Return good files with bytes flipped, dropped, repeated, swapped with those of others, or put in."""

    def mutated(seed: bytes, changes: list[tuple[int, int, int, bytes]]) -> bytes:
        data = seed
        for kind, place, length, put in changes:
            at = place % (len(data) + 1)
            piece = data[at : at + length]
            data = data[:at] + (piece * 3, b"", put, piece[::-1])[kind] + data[at + length * (kind != 2) :]
        return data

    piece = st.sampled_from(TOKENS) | st.binary(max_size=4) | st.sampled_from(seeds).map(lambda seed: seed[-40:])
    change = st.tuples(st.integers(0, 3), st.integers(0, 400), st.integers(0, 12), piece)
    return st.binary(max_size=60) | st.builds(mutated, st.sampled_from(seeds), st.lists(change, max_size=4))


def operations(work: Callable[[], object]) -> int:
    """Return the number of calls of functions, of Python and of C, that some work makes."""
    count = 0

    def note(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def peak_memory(work: Callable[[], object]) -> int:
    """Return the largest memory that some work holds at once [bytes]."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
