import hashlib
import threading
from contextlib import closing

from hypothesis import given
from hypothesis import strategies as st

from storage.hashing import AT_ONCE, BackgroundHash


@given(st.lists(st.sampled_from((0, 1, 100, AT_ONCE // 2, AT_ONCE, AT_ONCE + 1)), max_size=6))
def test_the_hash_is_that_of_all_blocks_in_order(sizes: list[int]) -> None:
    blocks = [bytes((number,)) * size for number, size in enumerate(sizes)]
    with closing(BackgroundHash()) as hashed:
        for block in blocks:
            hashed.add(memoryview(block))
        assert hashed.end() == hashlib.sha256(b"".join(blocks)).hexdigest()


def test_only_long_data_starts_a_thread_that_ends_with_the_hash() -> None:
    before = set(threading.enumerate())
    with closing(BackgroundHash()) as hashed:
        hashed.add(bytes(AT_ONCE - 1))
        assert set(threading.enumerate()) == before
        hashed.add(b"x")
        assert len(set(threading.enumerate()) - before) == 1
    assert set(threading.enumerate()) == before
