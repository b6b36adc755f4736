"""Recorder of a machine: files of recordings and rings on a disk, and its faults."""

import errno
from pathlib import Path

import pytest

from engine.recorder import robot_recorder
from engine.recorder.frames import Left, RecordedBatch, Told
from engine.recorder.main import PAUSE, MachineRecorder
from engine.recorder.robot_recorder import FLUSH_PERIOD, SEGMENT, OpenFile
from ppaas.recording.batches import Batch, BatchedMessage, batch_bytes
from ppaas.recording.writer import Encoded, encoded
from storage.disk_space import DiskReserve, DiskSpace
from storage.recordings import RecordingsFolder
from tests.support.recordings.entries import ABOUT, entry, read, scan, text

ALL = ("*",)


class Machine:
    """Recorder with a clock."""

    def __init__(self, path: Path, reserve: DiskReserve | None = None) -> None:
        self.folder = RecordingsFolder(path)
        self.told: list[Told] = []
        self.recorder = MachineRecorder(self.folder, reserve, self.told.append)
        self.now = 0.0

    def take(self, *entries: BatchedMessage, recording: str = "", ring: float = 0.0, ring_bytes: int = 10**9) -> None:
        batch = Batch(ABOUT, ring, ring_bytes, ALL if ring else (), recording, ALL, list(entries))
        self.recorder.take(RecordedBatch("ann", "tb1", batch_bytes(batch)), self.now)
        self.recorder.look(self.now)

    def leave(self) -> None:
        self.recorder.take(Left("ann", "tb1"), self.now)

    def topics(self, path: Path) -> list[str]:
        return [message.channel.topic for message in read(path.read_bytes())[1]]

    def ring(self) -> list[list[str]]:
        return [self.topics(segment.path) for segment in self.folder.segments("ann", "tb1")]


ID = "20261126T224142Z"


def test_recording_is_complete_when_it_ends(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.take(text("map_name", "office"), entry("scan", scan()), recording=ID)
    (stored,) = machine.folder.recordings("ann", "tb1")
    assert (stored.id, stored.finished) == (ID, False)
    machine.take(entry("scan", scan(1), 1))
    (stored,) = machine.folder.recordings("ann", "tb1")
    assert stored.finished
    assert machine.topics(stored.path) == ["/map_name", "/scan"]
    assert machine.told == [Told("ann", "tb1", forgotten=True)]
    assert stored.path.stat().st_mode & 0o077 == 0


def test_container_that_leaves_ends_its_files(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.take(entry("scan", scan()), recording=ID, ring=60.0)
    machine.leave()
    assert machine.folder.recording("ann", "tb1", ID).finished
    assert not read(machine.folder.segments("ann", "tb1")[0].path.read_bytes())[0].cut


def test_recorder_that_is_killed_leaves_what_was_flushed(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.take(entry("scan", scan()), recording=ID, ring=60.0)
    machine.now = FLUSH_PERIOD
    machine.take(recording=ID, ring=60.0)
    reader, messages = read(machine.folder.recording("ann", "tb1", ID).path.read_bytes())
    assert (len(messages), reader.cut) == (1, True)
    assert machine.ring() == [["/scan"]]
    again = Machine(tmp_path)  # the clone goes on with the recording: another file continues it
    again.take(entry("scan", scan(9), 9), recording=ID, ring=60.0)
    again.leave()
    assert [stored.id for stored in again.folder.recordings("ann", "tb1")] == [f"{ID}-2", ID]
    assert len(again.ring()) == 2


def test_ring_has_segments_that_each_begin_with_latched_messages(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    machine.take(text("map_name", "office"), ring=60.0)
    for number in range(1, 12):
        machine.now = number * (SEGMENT + 1.0)
        machine.take(entry("scan", scan(), round(machine.now)), ring=60.0)
    machine.leave()
    segments = machine.folder.segments("ann", "tb1")
    assert 4 <= len(segments) <= 5  # 60 s, and the segment in which they begin
    assert all(topics == ["/map_name", "/scan"] for topics in machine.ring())
    repeated = read(segments[-1].path.read_bytes())[1][0]
    assert (repeated.sequence, repeated.log_time) == (0, segments[-1].begin)


def test_ring_is_bounded_in_size(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    for number in range(6):
        machine.now = number * (SEGMENT + 1.0)
        machine.take(entry("scan", scan(), round(machine.now)), ring=3600.0, ring_bytes=5000)
    assert sum(segment.size for segment in machine.folder.segments("ann", "tb1")[:-1]) < 5000 + 5000
    assert len(machine.folder.segments("ann", "tb1")) < 4


def test_goal_is_repeated_until_it_ends(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    goal = entry("move_base/goal", scan(), kept=True)
    machine.take(goal, ring=60.0)
    machine.now = SEGMENT + 1.0
    machine.take(entry("scan", scan(), 21), ring=60.0)
    ended = BatchedMessage(
        goal.topic, goal.type, goal.up, goal.latched, goal.kept, goal.log_time, goal.publish_time, b""
    )
    machine.now = 2.0 * SEGMENT + 2.0
    machine.take(ended, entry("scan", scan(), 42), ring=60.0)
    machine.leave()
    assert machine.ring() == [["/move_base/goal"], ["/move_base/goal", "/scan"], ["/scan"]]


def test_messages_that_cannot_be_encoded_are_left_out(tmp_path: Path) -> None:
    machine = Machine(tmp_path)
    odd = entry("odd", scan())
    machine.take(
        BatchedMessage(odd.topic, "acme_msgs/Anvil", True, False, False, odd.log_time, odd.log_time, b"{}"),
        BatchedMessage(odd.topic, odd.type, True, False, False, odd.log_time, odd.log_time, b'{"ranges": "x"}'),
        entry("scan", scan()),
        ring=60.0,
    )
    machine.leave()
    assert machine.ring() == [["/scan"]]


# -- faults ------------------------------------------------------------------------------------------------------------


def test_full_disk_ends_recordings_and_is_told_until_there_is_space(tmp_path: Path) -> None:
    free = [DiskSpace(1 << 40, 0, 1000)]
    reserve = DiskReserve(tmp_path, lambda _: free[0])
    machine = Machine(tmp_path, reserve)
    machine.take(entry("scan", scan()), ring=60.0)
    assert "the disk of the cloud is full" in machine.told[-1].problem
    machine.now = 1.0
    machine.take(entry("scan", scan()), ring=60.0)
    assert machine.told[-1].problem  # nothing is tried for a while
    (tmp_path / "disk-reserve").touch()
    free[0] = DiskSpace(1 << 40, 1 << 39, 1000)
    machine.now = 2.0 * PAUSE
    machine.take(entry("scan", scan()), ring=60.0)
    assert machine.told[-2:] == [Told("ann", "tb1"), Told("ann", "tb1", forgotten=True)]
    machine.leave()
    assert machine.ring()[-1] == ["/scan"]


def test_disk_that_fails_while_a_file_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(tmp_path)
    machine.take(entry("scan", scan()), recording=ID)
    machine.now = FLUSH_PERIOD
    machine.take(recording=ID)

    def fail(file: OpenFile, message: Encoded, *, log_time: int | None = None) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(OpenFile, "add", fail)
    machine.take(entry("scan", scan()), recording=ID)
    assert "No space left on device" in machine.told[-1].problem
    assert not machine.folder.recording("ann", "tb1", ID).finished


def test_sizes_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_recorder, "MOST_BYTES", 100)
    machine = Machine(tmp_path)
    machine.take(entry("scan", scan()), recording=ID)
    assert "the largest size" in machine.told[-1].problem
    assert machine.folder.recording("ann", "tb1", ID).finished
    monkeypatch.setattr(robot_recorder, "MOST_USER_BYTES", 100)
    machine.now = 2.0 * PAUSE
    machine.take(entry("scan", scan()), recording="20261126T224143Z")
    assert "delete some" in machine.told[-1].problem


def test_fault_of_one_robot_leaves_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine(tmp_path)
    machine.recorder.take(RecordedBatch("ann", "tb2", b"\xc1"), 0.0)
    assert "not a batch" in machine.told[-1].problem
    machine.take(entry("scan", scan()), ring=60.0)
    machine.leave()
    assert machine.ring() == [["/scan"]]


def test_abandoned_file_has_what_was_flushed(tmp_path: Path) -> None:
    for name, flushed in (("a", True), ("b", False)):
        file = OpenFile(tmp_path / name, ABOUT, 0.0)
        file.add(encoded(entry("scan", scan())))
        file.flush(FLUSH_PERIOD if flushed else 0.0)
        file.add(encoded(entry("scan", scan())))
        file.abandon()
    assert len(read((tmp_path / "a").read_bytes())[1]) == 1
    assert not (tmp_path / "b").exists()
