import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import InvalidGraph
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.serialization import mapping_log
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.mapping.serialization.mapping_log import GrowingMapping, LogWriter, Rewritten, read_log
from ppaas.mapping.serialization.rows import packed_rows
from tests.support.world.mappings import extend_tour, room_mapping


class Log:
    """Log of a mapping that grows, kept by number."""

    def __init__(self):
        self.mapping = room_mapping(0)
        self.entries, self.solves, self.renewals, self.waiting = {}, 0, 0, []
        self.writer = LogWriter("laser")

    def grow(self, frames=0, closures=0, solves=0):
        for _ in range(frames):
            extend_tour(self.mapping.frames, self.mapping.graph)
        last = len(self.mapping.frames) - 1
        for k in range(closures):
            self.mapping.graph.add_edge(k, last, (0.1, 0.2, 0.3), np.eye(3), EdgeKind.CLOSURE)
        if solves:
            self.mapping.frames.poses[1:] += 0.01
            self.mapping.graph.move_nodes(self.mapping.frames.poses)
        self.solves += solves

    def renew(self):
        graph = self.mapping.graph
        closures = np.flatnonzero(graph.edges.kinds == EdgeKind.CLOSURE)
        graph.renew_measurements(closures, graph.edges.measurements[closures] + 0.001)
        self.renewals += 1

    def write(self):
        growing = GrowingMapping(self.mapping.frames, self.mapping.graph, self.solves, self.waiting)
        change = self.writer.write(growing._replace(renewals=self.renewals))
        if change is not None:
            self.keep(change)
        return change

    def keep(self, change):
        self.entries |= dict(change.entries)
        for number in change.obsolete:
            del self.entries[number]

    def read(self):
        return read_log(LogEntry(number, self.entries[number]) for number in sorted(self.entries))

    def assert_is_whole(self):
        packed, expected = (b"".join(pack_mapping(each)) for each in (self.read(), self.mapping))
        assert packed == expected


@pytest.fixture
def log(monkeypatch):
    monkeypatch.setattr(mapping_log, "FOLD", 8)
    return Log()


def test_a_log_is_whole_after_every_key_frame_closure_and_solve(log):
    random = np.random.default_rng(5)
    for _ in range(30):
        log.grow(1, closures=int(random.random() < 0.3), solves=int(random.random() < 0.3))
        log.write()
        assert len(log.entries) <= 1 + 30 // 8 + 8 + 9 + 2
    log.assert_is_whole()


def test_an_entry_is_written_for_what_is_new_only(log):
    log.grow(5)
    assert len(log.write().entries) == 2
    assert log.write() is None
    log.grow(1)
    (entry,) = log.write().entries
    assert len(entry.data) < 1200
    log.grow(0, closures=1, solves=1)
    assert [len(log.write().entries), log.write()] == [2, None]
    log.assert_is_whole()


def test_poses_of_a_later_solve_replace_the_earlier_ones(log):
    log.grow(5, solves=1)
    log.write()
    log.grow(solves=1)
    assert len(log.write().obsolete) == 1
    log.assert_is_whole()


def test_many_small_entries_become_one(log):
    log.grow(1)
    for _ in range(40):
        log.grow(1, closures=1)
        log.write()
    assert len(log.entries) < 25
    log.assert_is_whole()


def test_a_change_that_was_not_stored_joins_the_next_one(log):
    log.grow(3, solves=1)
    lost = log.writer.write(GrowingMapping(log.mapping.frames, log.mapping.graph, 1, []))
    log.grow(1, solves=1)
    later = log.writer.write(GrowingMapping(log.mapping.frames, log.mapping.graph, 2, []))
    joined = lost.then(later)
    assert not {entry.number for entry in joined.entries} & set(joined.obsolete)
    log.entries = dict(joined.entries)
    log.assert_is_whole()


def test_a_new_mapping_makes_the_old_one_obsolete(log):
    log.grow(3)
    log.write()
    old = set(log.entries)
    log.writer, log.mapping = LogWriter("other", log.writer.number, old), room_mapping(2)
    assert set(log.write().obsolete) == old
    assert (log.read().laser_frame, len(log.read().frames)) == ("other", 2)


def test_a_log_goes_on_after_it_was_read(log):
    random = np.random.default_rng(6)
    for step in range(40):
        log.grow(1, closures=int(random.random() < 0.4) * (step > 0), solves=int(random.random() < 0.3))
        log.write()
        if step % 7 == 3:
            entries = [LogEntry(number, log.entries[number]) for number in sorted(log.entries)]
            log.mapping, log.solves = read_log(entries), 0
            log.writer = LogWriter.resumed(entries, log.mapping)
            assert log.write() is None
            assert len(entries) < 25
    log.assert_is_whole()


def test_a_large_mapping_is_written_in_parts(log, monkeypatch):
    monkeypatch.setattr(mapping_log, "MOST_FRAMES", 16)
    log.grow(30, closures=2)
    assert len(log.write().entries) == 1 + 2
    assert len(log.read().frames) == 16
    assert len(log.write().entries) == 2 + 1
    assert log.write() is None
    log.assert_is_whole()


def test_frames_that_an_interrupted_removal_left_twice_count_once(log):
    for _ in range(7):
        log.grow(1)
        log.write()
    before = dict(log.entries)
    log.grow(1)
    log.write()
    log.entries = before | log.entries
    log.assert_is_whole()


def test_waiting_closures_come_back(log):
    log.grow(4)
    edges = room_mapping(2).graph.edges
    log.waiting = [
        Closure(Submap(2, 4), Submap(0, 1), edges, 0.75, Pose2D(1.0, 2.0, 3.0), wide=True),
        Closure(Submap(3, 4), Submap(0, 2), edges.since(1), 0.5, Pose2D(0.0, 0.0, 0.1), wide=False),
    ]
    log.write()
    first, second = log.read().waiting
    assert (first.source, first.target, first.score, first.motion, first.wide) == (
        (2, 4), (0, 1), 0.75, Pose2D(1.0, 2.0, 3.0), True,
    )  # fmt: skip
    np.testing.assert_array_equal(first.edges.measurements, edges.measurements)
    assert (len(second.edges.first), second.wide) == (0, False)
    log.waiting = [Closure(Submap(2, 9), Submap(0, 1), edges, 0.75, Pose2D(1.0, 2.0, 3.0), wide=True)]
    log.write()
    with pytest.raises(InvalidGraph, match="waiting closure"):
        log.read()


def test_a_log_that_lacks_an_entry_is_refused(log):
    for _ in range(3):
        log.grow(1)
        log.write()
    del log.entries[2]
    with pytest.raises(InvalidGraph, match="lacks key frames 1 to 1"):
        log.read()
    with pytest.raises(InvalidGraph, match="no key frame"):
        read_log([])


def test_an_empty_entry_is_refused(log):
    log.grow(3)
    log.write()
    log.grow(1)
    log.write()
    log.entries[max(log.entries)] = b""
    with pytest.raises(InvalidGraph, match="entry 2 of the log of the pose graph is empty"):
        log.read()


def test_a_rewritten_mapping_is_one_entry_that_a_log_continues(log):
    log.grow(30, closures=3, solves=1)
    log.write()
    frames, graph = log.mapping.frames, log.mapping.graph
    others = graph.edge_count - len(frames) + 1
    rows = b"".join(packed_rows(frames, graph))
    rewritten = Rewritten(rows, len(frames), graph.edge_count, others, log.solves)
    log.grow(2, closures=1)
    log.writer = log.writer.restarted(sorted(log.entries))
    log.keep(log.writer.write(GrowingMapping(frames, graph, log.solves, log.waiting, rewritten)))
    assert len(log.entries) == 3
    log.assert_is_whole()
    for _ in range(20):
        log.writer = LogWriter.resumed(
            [LogEntry(number, log.entries[number]) for number in sorted(log.entries)], log.read()
        )
        log.solves = 0
        log.grow(1, closures=1)
        log.write()
        log.assert_is_whole()
    assert len(log.entries) <= 1 + 20 // 8 + 8 + 9 + 2
    first, *_ = (LogEntry(number, log.entries[number]) for number in sorted(log.entries))
    assert len(read_log([first]).frames) == 30


@pytest.mark.parametrize("rewritten", [False, True])
@pytest.mark.parametrize("resumed", [False, True])
def test_closures_that_get_other_measurements_replace_those_before(log, resumed, rewritten):
    log.grow(4, closures=3)
    log.write()
    if rewritten:
        frames, graph = log.mapping.frames, log.mapping.graph
        rows = Rewritten(b"".join(packed_rows(frames, graph)), len(frames), graph.edge_count, 3, 0)
        log.writer = log.writer.restarted(sorted(log.entries))
        log.keep(log.writer.write(GrowingMapping(frames, graph, 0, [], rows)))
    for _ in range(3):
        log.renew()
        assert len(log.write().entries) == 1
        assert log.write() is None
        log.assert_is_whole()
        if resumed:
            entries = [LogEntry(*entry) for entry in sorted(log.entries.items())]
            log.writer, log.renewals = LogWriter.resumed(entries, read_log(entries)), 0
        for _ in range(10):  # more than are written one by one
            log.grow(1, closures=1)
            log.write()
            log.assert_is_whole()
    assert len(log.entries) < 30


def test_a_renewal_without_closures_writes_nothing(log):
    log.grow(4)
    log.write()
    log.renewals += 1
    assert log.write() is None
