"""File of revoked tokens that are not removed from the store yet."""

from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.disk_space import refused_tokens
from storage.disk_space.refused_tokens import REFUSED_TOKENS, SLOT, SLOTS, RefusedTokenFile

HASHES = [f"{number:064x}" for number in range(5)]


def opened(folder: Path, slots: int = SLOTS) -> tuple[RefusedTokenFile, list[tuple[str, str]]]:
    file = RefusedTokenFile(folder, slots)
    return file, file.open()


def test_tokens_are_there_after_a_restart_until_they_are_removed(tmp_path: Path) -> None:
    file, found = opened(tmp_path)
    assert found == []
    for token_hash in HASHES:
        file.add("a" * 64, token_hash)
    file.add("a" * 64, HASHES[0])
    file.remove("a" * 64, HASHES[1])
    again, found = opened(tmp_path)
    assert found == [("a" * 64, token_hash) for number, token_hash in enumerate(HASHES) if number != 1]
    again.add("bob", HASHES[1])
    assert sorted(opened(tmp_path)[1])[-1] == ("bob", HASHES[1])


def test_the_file_takes_its_space_before_it_is_needed(tmp_path: Path) -> None:
    file, _ = opened(tmp_path)
    path = tmp_path / REFUSED_TOKENS
    before = path.stat()
    assert before.st_size == SLOT * SLOTS and before.st_blocks * 512 >= before.st_size, "no holes"
    assert before.st_mode & 0o077 == 0
    for token_hash in HASHES:
        file.add("ann", token_hash)
    assert path.stat().st_blocks == before.st_blocks
    assert path.stat().st_ino == before.st_ino, "it is written in place"


def test_tokens_without_space_are_not_acknowledged(tmp_path: Path) -> None:
    file, _ = opened(tmp_path, slots=2)
    for token_hash in HASHES[:2]:
        file.add("ann", token_hash)
    with pytest.raises(Unavailable, match="revoke it again"):
        file.add("ann", HASHES[2])
    file.remove("ann", HASHES[0])
    file.add("ann", HASHES[2])
    assert sorted(opened(tmp_path, slots=2)[1]) == [("ann", HASHES[1]), ("ann", HASHES[2])]


def test_a_token_that_was_half_written_is_none(tmp_path: Path) -> None:
    file, _ = opened(tmp_path)
    for token_hash in HASHES[:3]:
        file.add("ann", token_hash)
    path = tmp_path / REFUSED_TOKENS
    content = bytearray(path.read_bytes())
    content[SLOT + 40] ^= 1
    path.write_bytes(content)
    assert opened(tmp_path)[1] == [("ann", HASHES[0]), ("ann", HASHES[2])]


def test_without_space_for_the_file_nothing_is_acknowledged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file, found = opened(tmp_path / "missing")
    assert found == [] and "cannot be kept" in caplog.text
    with pytest.raises(Unavailable, match="could not be stored"):
        file.add("ann", HASHES[0])


def test_a_disk_that_fails_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, _ = opened(tmp_path)
    file.add("ann", HASHES[0])

    def fail(_handle: int) -> None:
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as patch:
        patch.setattr(refused_tokens.os, "fdatasync", fail)
        with pytest.raises(Unavailable, match="Input/output error"):
            file.add("ann", HASHES[1])
        file.remove("ann", HASHES[0])
    assert (tmp_path / REFUSED_TOKENS).stat().st_size == SLOT * SLOTS
