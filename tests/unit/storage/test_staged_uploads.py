import hashlib
import os
from pathlib import Path

import pytest

from storage.records import MapFile
from storage.staged_uploads import StagedUpload


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
