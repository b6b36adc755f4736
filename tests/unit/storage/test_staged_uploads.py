import hashlib
import os
from pathlib import Path

import pytest

from storage.records import MapFile
from storage.staged_uploads import StagedUpload


def test_a_file_is_hashed_as_it_is_written(tmp_path: Path) -> None:
    draft = StagedUpload(tmp_path)
    blocks = [os.urandom(size) for size in (1, 1 << 17, 0, 7)]
    draft.add("image", blocks)
    whole = b"".join(blocks)
    assert draft.files["image"] == MapFile(hashlib.sha256(whole).hexdigest(), len(whole))
    assert bytes(draft.buffer("image")) == whole


def test_the_disk_begins_with_what_has_come_while_more_comes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "posix_fadvise", lambda _file, first, size, _advice: begun.append((first, size)))
    draft = StagedUpload(tmp_path)
    with draft.writing("image") as file:
        for _ in range(40):
            file.write(bytes(1 << 20))
        early = sum(size for _, size in begun)
    assert early > 30 << 20
    assert [first for first, _ in begun] == [sum(size for _, size in begun[:n]) for n in range(len(begun))]


def test_a_file_that_was_not_written_to_its_end_is_not_in_the_draft(tmp_path: Path) -> None:
    draft = StagedUpload(tmp_path)
    with pytest.raises(RuntimeError), draft.writing("image") as file:
        file.write(b"half")
        raise RuntimeError("the form is cut short")
    assert not draft.files
