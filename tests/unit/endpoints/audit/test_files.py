"""Files of the audit log.

Kinds of damage: an incomplete last line, bytes that are no UTF-8, a line that is JSON of another kind, a line longer
than any event, a file that was removed.
"""

import os
import stat
import threading
from pathlib import Path

import pytest

from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.files import BLOCK, AuditFiles

ALL = AuditQuery()


def event(action: str = "put_robot", **fields: object) -> AuditEvent:
    return AuditEvent(action=action, **fields)  # type: ignore[arg-type]


def numbers(files: AuditFiles, query: AuditQuery = ALL, before: int | None = None, limit: int = 10_000) -> list[int]:
    return [found.number for found in files.read(query, before=before, limit=limit)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "audit.jsonl"


def test_events_are_numbered_and_read_newest_first(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event(), event()])
    files.append([event()])
    assert numbers(files) == [3, 2, 1]
    assert numbers(files, before=3, limit=1) == [2]


def test_only_the_owner_may_read_the_file(path: Path) -> None:
    AuditFiles(path).append([event()])
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_events_are_found_by_user_action_outcome_and_time(path: Path) -> None:
    files = AuditFiles(path)
    files.append(
        [
            event(user="ann", time=1.0),
            event("remove_map", user="ann", time=2.0, outcome="refused"),
            event(user='b"ob', time=3.0),
        ]
    )
    assert numbers(files, AuditQuery(user="ann")) == [2, 1]
    assert numbers(files, AuditQuery(user='b"ob')) == [3]
    assert numbers(files, AuditQuery(action="remove_map")) == [2]
    assert numbers(files, AuditQuery(outcome="ok")) == [3, 1]
    assert numbers(files, AuditQuery(after=2.0)) == [3, 2]


def test_events_of_an_object_include_its_parts(path: Path) -> None:
    files = AuditFiles(path)
    names = ("robots/tb1", "robots/tb10", "robots/tb1/goals/7", None, "maps/robots/tb1")
    files.append([event(object=name) for name in names])
    assert numbers(files, AuditQuery(object="robots/tb1")) == [3, 1]
    assert numbers(files, AuditQuery(object="robots")) == [3, 2, 1]
    assert numbers(files, AuditQuery(object="")) == []


def test_numbers_go_on_after_a_restart_and_after_a_rotation(path: Path) -> None:
    AuditFiles(path, max_size=1).append([event()])
    AuditFiles(path, max_size=1).append([event()])
    assert numbers(AuditFiles(path)) == [2, 1]


def test_the_oldest_file_is_dropped(path: Path) -> None:
    files = AuditFiles(path, max_size=1, files=3)
    for _ in range(5):
        files.append([event()])
    assert sorted(one.name for one in path.parent.iterdir()) == ["audit.jsonl.1", "audit.jsonl.2"]
    files.append([])
    assert numbers(files) == [5, 4]


@pytest.mark.parametrize("damage", [b'{"number":2,"acti', b"\xff\xfe\n", b"[1, 2]\n", b"\0" * (3 * BLOCK), b"\n\n"])
def test_a_damaged_line_affects_no_other_line(path: Path, damage: bytes) -> None:
    AuditFiles(path).append([event()])
    with path.open("ab") as file:
        file.write(damage)
    files = AuditFiles(path)
    files.append([event()])
    assert numbers(files) == [2, 1]


def test_pages_of_a_large_file_are_complete(path: Path) -> None:
    files = AuditFiles(path)
    for _ in range(20):
        files.append([event(details={"text": "x" * 400})] * 100)
    assert path.stat().st_size > 8 * BLOCK
    found, before = list[int](), None
    while page := numbers(files, before=before, limit=170):
        found += page
        before = page[-1]
    assert found == list(range(2000, 0, -1))


def test_two_processes_append_without_losing_or_repeating_a_number(path: Path) -> None:
    ours, theirs = AuditFiles(path, max_size=500, files=50), AuditFiles(path, max_size=500, files=50)
    for _ in range(20):
        ours.append([event()])
        theirs.append([event(), event()])
    assert numbers(ours) == list(range(60, 0, -1))


def test_an_append_that_fails_leaves_no_part_of_it(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = AuditFiles(path)
    files.append([event()])
    before = path.read_bytes()
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, data: write(file, data[:9]) if len(data) > 40 else _full())
    with pytest.raises(OSError, match="No space left"):
        files.append([event()])
    monkeypatch.undo()
    assert path.read_bytes() == before
    files.append([event()])
    assert numbers(files) == [2, 1]


def _full() -> int:
    raise OSError(28, "No space left on device")


def test_a_text_that_is_not_unicode_keeps_no_event_from_being_stored(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event(object="\ud800"), event(object="robots/tb1")])
    assert [found.object for found in files.read(ALL)] == ["robots/tb1", None]


def test_a_file_that_was_removed_begins_anew(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event()])
    path.unlink()
    files.append([event()])
    assert numbers(files) == [1]


def test_a_file_that_cannot_be_opened_leaves_no_other_open(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event()])
    path.with_name("audit.jsonl.1").symlink_to(path)
    before = open_files()
    for _ in range(5):
        with pytest.raises(OSError):
            files.read(ALL)
    assert open_files() == before


def open_files() -> set[str]:
    """Return the files that this process has open, by number."""
    with os.scandir("/proc/self/fd") as found:
        return {entry.name for entry in found}


# -- events that have expired ------------------------------------------------------------------------------------------


def test_old_events_are_removed_from_all_files_and_numbers_go_on(path: Path) -> None:
    files = AuditFiles(path, max_size=150)
    for second in range(8):
        files.append([event(time=float(second))])
    assert path.with_name("audit.jsonl.2").exists()
    assert files.expire(5.0, dry_run=True) == 5
    assert numbers(files) == list(range(8, 0, -1))
    assert files.expire(5.0) == 5
    assert numbers(files) == [8, 7, 6]
    assert files.expire(5.0) == 0
    files.append([event(time=9.0)])
    assert numbers(files, limit=1) == [9]


def test_the_last_event_stays_however_old_it_is(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event(time=1.0), event(time=2.0)])
    assert files.expire(1e9) == 1
    assert numbers(files) == [2]
    AuditFiles(path).append([event()])
    assert numbers(files) == [3, 2]


def test_a_file_without_old_events_keeps_its_inode_and_a_changed_one_its_time_and_mode(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event(time=1.0), event(time=5.0), event(time=6.0)])
    before = path.stat()
    assert files.expire(1.0) == 0
    assert path.stat().st_ino == before.st_ino
    assert files.expire(2.0) == 1
    after = path.stat()
    assert (after.st_mtime_ns, stat.S_IMODE(after.st_mode)) == (before.st_mtime_ns, 0o600)


def test_damaged_lines_are_no_reason_to_remove_anything(path: Path) -> None:
    files = AuditFiles(path)
    files.append([event(time=1.0)])
    with path.open("ab") as file:
        file.write(b"{broken\n")
    files.append([event(time=5.0)])
    assert files.expire(2.0) == 1
    assert b"{broken" in path.read_bytes()
    assert numbers(files) == [2]


def test_events_that_are_appended_meanwhile_are_kept(path: Path) -> None:
    AuditFiles(path).append([event(time=1.0)])
    ready = threading.Barrier(3)

    def append() -> None:
        own = AuditFiles(path)
        ready.wait()
        for _ in range(50):
            own.append([event(time=9.0)])

    threads = [threading.Thread(target=append) for _ in range(2)]
    for thread in threads:
        thread.start()
    ready.wait()
    files = AuditFiles(path)
    removed = sum(files.expire(2.0) for _ in range(20))
    for thread in threads:
        thread.join()
    assert removed + files.expire(2.0) == 1
    assert numbers(files) == list(range(101, 1, -1))
