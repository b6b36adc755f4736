import hashlib
import os
import threading
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from storage.records import MapFile
from storage.staged_uploads import AT_ONCE, BackgroundHash, StagedUpload


def test_a_file_is_hashed_as_it_is_written(tmp_path: Path) -> None:
    upload = StagedUpload(tmp_path)
    blocks = [os.urandom(size) for size in (1, 1 << 17, 0, 7)]
    upload.add("image", blocks)
    whole = b"".join(blocks)
    assert upload.files["image"] == MapFile(hashlib.sha256(whole).hexdigest(), len(whole))
    assert bytes(upload.buffer("image")) == whole


def test_writeback_starts_while_a_file_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "posix_fadvise", lambda _file, first, size, _advice: begun.append((first, size)))
    upload = StagedUpload(tmp_path)
    with upload.writing("image") as file:
        for _ in range(40):
            file.write(bytes(1 << 20))
        early = sum(size for _, size in begun)
    assert early > 30 << 20
    assert [first for first, _ in begun] == [sum(size for _, size in begun[:n]) for n in range(len(begun))]


def test_a_file_whose_block_failed_is_not_in_the_upload(tmp_path: Path) -> None:
    upload = StagedUpload(tmp_path)
    with pytest.raises(RuntimeError), upload.writing("image") as file:
        file.write(b"half")
        raise RuntimeError("the form is cut short")
    assert not upload.files


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
