"""Live mapper: one search at a time, on copies, whose result is applied when it is done."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import WAITING
from ppaas.mapping.closures.closure import Closure, Searched
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges
from ppaas.mapping.graph.solver import Robust
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.live import background_work
from ppaas.mapping.live.background_work import Closed, ThinnedMap
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.mapping.serialization.mapping_log import LogWriter, read_log
from tests.support.world.room_scans import LASER, scan_at

GEOMETRY = LaserGeometry(-1.5, 0.1, 31)
BLIND = prepare(np.full(31, np.nan), GEOMETRY, SlamParameters())


def closure(source: int, target: int, x: float, *, wide: bool = False) -> Closure:
    edges = Edges(
        np.array([target]), np.array([source]), np.array([(x, 0.0, 0.0)]), np.diag((900.0, 900.0, 9000.0))[None],
        np.array([EdgeKind.CLOSURE], np.uint8),
    )  # fmt: skip
    return Closure(Submap(source, source + 1), Submap(target, target + 1), edges, 0.9, Pose2D(0.0, 0.0), wide)


def drive(mapper: LiveMapper, count: int) -> None:
    """Drive 0.5 m per scan along x; every scan is a key frame."""
    begin = len(mapper.key_frames)
    for number in range(begin, begin + count):
        mapper.add(BLIND, Pose2D(0.5 * number, 0.0))


@pytest.fixture
def mapper(monkeypatch) -> LiveMapper:
    found = LiveMapper(GEOMETRY)
    monkeypatch.setattr(found._search, "search", lambda *_: Searched())
    drive(found, 40)
    return found


def never() -> bool:
    return False


def test_submaps_are_searched_one_after_the_other(mapper):
    lengths = []
    while (work := mapper.next_work()) is not None:
        assert mapper.next_work() is None
        lengths.append(len(work.submaps))
        assert mapper.apply(work(never)) is None
    assert lengths == [1, 2, 3, 4, 5, 6]


def test_work_changes_nothing_and_may_be_run_again(mapper, monkeypatch):
    work = mapper.next_work()
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched([closure(30, 2, 14.1)]))
    poses, edges = mapper.key_frames.poses.copy(), mapper.graph.edge_count
    first, second = work(never), work(never)
    np.testing.assert_array_equal(first.poses, second.poses)
    np.testing.assert_array_equal(first.canvas.cells, second.canvas.cells)
    np.testing.assert_array_equal(mapper.key_frames.poses, poses)
    np.testing.assert_array_equal(work.frames.poses, poses)
    assert mapper.graph.edge_count == work.graph.edge_count == edges


def test_a_result_moves_the_frames_that_came_meanwhile_along(mapper, monkeypatch):
    work = mapper.next_work()
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched([closure(30, 2, 14.1)]))
    closed = work(never)
    drive(mapper, 100)
    motion = mapper.apply(closed)
    poses = mapper.key_frames.poses
    np.testing.assert_array_equal(poses[:40], closed.poses)
    np.testing.assert_allclose(np.diff(poses[39:], axis=0), [(0.5, 0.0, 0.0)] * 100, atol=1e-5)
    np.testing.assert_array_equal(poses, mapper.graph.poses)
    np.testing.assert_allclose(poses[0], (0.0, 0.0, 0.0))
    assert motion.x == pytest.approx(poses[-1, 0] - 0.5 * 139, abs=1e-5)
    assert mapper.closed == 1
    assert mapper.draw() is closed.canvas


def test_cancelled_and_failed_work_is_given_up(mapper):
    assert mapper.next_work()(lambda: True) is None
    assert mapper.apply(None) is None
    assert mapper.next_work() is not None


def test_lone_closures_of_wide_windows_wait_and_are_bounded(mapper, monkeypatch):
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched([closure(30, 2, 14.1, wide=True)]))
    closed = mapper.next_work()(never)
    assert (closed.trusted, len(closed.waiting), closed.poses) == ([], 1, None)
    mapper.apply(Closed(Searched(), [], closed.waiting * (WAITING + 5)))
    assert len(mapper.next_work().waiting) == WAITING


def test_without_parameters_no_loops_are_closed():
    mapper = LiveMapper(GEOMETRY, closures=None)
    drive(mapper, 40)
    assert mapper.next_work() is None


def test_a_snapshot_does_not_see_later_frames(mapper):
    taken, poses = mapper.key_frames.snapshot(), mapper.key_frames.poses.copy()
    drive(mapper, 100)
    mapper.key_frames.poses[:] += 1.0
    assert len(taken) == 40
    np.testing.assert_array_equal(taken.poses, poses)


def test_a_mapper_resumes_where_another_one_ended(mapper):
    while (work := mapper.next_work()) is not None:
        mapper.apply(work(never))
    resumed = LiveMapper(GEOMETRY)
    resumed.resume(mapper.mapping("laser"), mapper.pose, mapper.odometry, mapper.searched)
    assert (resumed.searched, resumed.closed) == (mapper.searched, 0)
    assert resumed.next_work() is None
    for each in (mapper, resumed):
        drive(each, 5)
    np.testing.assert_array_equal(resumed.key_frames.poses, mapper.key_frames.poses)
    np.testing.assert_array_equal(resumed.graph.edges.measurements, mapper.graph.edges.measurements)
    np.testing.assert_array_equal(resumed.draw().cells, mapper.draw().cells)


@pytest.fixture
def room() -> LiveMapper:
    """Mapper with 20 key frames of a room; the room is searched for no closures."""
    return toured(LiveMapper(LASER, closures=None), range(20))


def toured(mapper: LiveMapper, steps) -> LiveMapper:
    for step in steps:
        mapper.add(scan_at(tour(step), noise=0.01, seed=step), tour(step))
    return mapper


def tour(step: int) -> Pose2D:
    return Pose2D(0.3 * step - 3.0, -1.0, 0.0)


def test_a_loaded_map_grows_in_its_own_frame(room):
    continued = LiveMapper(LASER, closures=None)
    continued.load(room.mapping("laser"), Pose2D(0.4, -0.8, 0.1))
    odometry = Pose2D(7.0, 8.0, 1.0)
    tracked = continued.add(scan_at(Pose2D(0.5, -1.0, 0.0), seed=90), odometry)
    np.testing.assert_allclose(tracked.pose, (0.5, -1.0, 0.0), atol=0.01)
    assert (tracked.is_key, len(continued.key_frames), continued.graph.node_count) == (True, 21, 21)
    tracked = continued.add(scan_at(Pose2D(0.9, -1.0, 0.0), seed=91), odometry @ Pose2D(0.4, 0.0, 0.0))
    np.testing.assert_allclose(tracked.pose, (0.9, -1.0, 0.0), atol=0.01)
    assert len(continued.key_frames) == 22
    read = unpack_mapping(b"".join(pack_mapping(continued.mapping("laser"))))
    assert (len(read.frames), read.graph.edge_count) == (22, 21)


def test_localization_leaves_the_map_as_it_is(room):
    count = len(room.key_frames)
    localized = LiveMapper(LASER, closures=None)
    before = room.draw().cells.copy()
    localized.load(room.mapping("laser"), tour(0), keeps=False)
    for step in range(60):
        pose = tour(step % 19)
        if step % 19 == 0:
            localized.place(pose)
        found = localized.add(scan_at(pose, noise=0.01, seed=step), pose).pose
        np.testing.assert_allclose(found, pose, atol=0.03)
    assert len(localized.key_frames) <= count + SlamParameters().scan_buffer_size
    assert len(localized.mapping("laser").frames) == localized.graph.node_count == count
    np.testing.assert_array_equal(localized.draw().cells, before)
    assert localized.next_work() is None


def test_a_scan_that_fits_nowhere_near_changes_nothing(room):
    continued = LiveMapper(LASER, closures=None)
    continued.load(room.mapping("laser"), Pose2D(-1.0, -1.0, 1.5))
    elsewhere = prepare(np.random.default_rng(3).uniform(0.3, 6.0, LASER.beams), LASER, SlamParameters())
    for _ in range(2):
        with pytest.raises(InvalidInput, match="does not fit the map within 1 m"):
            continued.add(elsewhere, Pose2D(0.0, 0.0, 0.0))
    assert len(continued.key_frames) == 20
    continued.place(tour(3))
    assert continued.add(scan_at(tour(3)), Pose2D(0.0, 0.0, 0.0)).is_key


def round_trips(mapper: LiveMapper, laps: int) -> None:
    """Drive round a circle of 1 m; thin when it is due."""
    begin = len(mapper.key_frames) and int(mapper.key_frames.scans[-1]) + 1
    for k in range(begin, begin + 30 * laps):
        go_round(mapper, k)
        while (work := mapper.next_work()) is not None:
            assert mapper.apply(work(never)) is None


def go_round(mapper: LiveMapper, k: int) -> None:
    """Add a key frame on the circle, the k-th."""
    angle = 2.0 * np.pi * k / 30
    pose = Pose2D(np.cos(angle), np.sin(angle) - 1.0, (angle + np.pi / 2.0 + np.pi) % (2.0 * np.pi) - np.pi)
    mapper.add(scan_at(pose, noise=0.01, seed=k), pose)


def thinning_after_five_laps(mapper: LiveMapper) -> ThinnedMap:
    """Go round five times, and return the first thinning, which is not applied."""
    for k in range(150):
        assert mapper.next_work() is None
        go_round(mapper, k)
    found = mapper.next_work()(never)
    assert isinstance(found, ThinnedMap)
    return found


LIFELONG = LifelongParameters(pass_distance=4.0, least_new_frames=20)


def test_a_lifelong_map_stops_growing_and_stays_whole():
    mapper = LiveMapper(LASER, closures=None, lifelong=LIFELONG)
    round_trips(mapper, 6)
    count, thinnings = len(mapper.key_frames), mapper.thinnings
    assert thinnings >= 2
    assert count < 150
    round_trips(mapper, 4)
    assert len(mapper.key_frames) <= count + 40
    assert mapper.graph.node_count == len(mapper.key_frames)
    np.testing.assert_array_equal(mapper.graph.poses, mapper.key_frames.poses)
    read = unpack_mapping(b"".join(pack_mapping(mapper.mapping("laser"))))
    assert len(read.frames) == len(mapper.key_frames)
    resumed = LiveMapper(LASER, closures=None)
    resumed.resume(read, mapper.pose, mapper.odometry, mapper.searched)
    assert resumed._submaps.finished == mapper._submaps.finished
    np.testing.assert_array_equal(resumed.draw().cells.shape, mapper.draw().cells.shape)


def test_a_thinned_map_begins_a_new_log_once():
    mapper = LiveMapper(LASER, closures=None, lifelong=LIFELONG)
    round_trips(mapper, 6)
    assert mapper.is_rewritten
    growing = mapper.growing()
    change = LogWriter("laser", 7, [1, 2]).write(growing)
    assert change.obsolete == [1, 2]
    read = read_log(change.entries)
    np.testing.assert_array_equal(read.frames.scans, mapper.key_frames.scans)
    np.testing.assert_array_equal(read.frames.poses, mapper.key_frames.poses)
    assert not mapper.is_rewritten and mapper.growing().rewritten is None


def test_thinning_during_which_the_robot_was_placed_on_a_removed_key_frame_is_given_up():
    mapper = LiveMapper(LASER, closures=None, lifelong=LifelongParameters(pass_distance=4.0, least_new_frames=150))
    found = thinning_after_five_laps(mapper)
    removed = int(np.flatnonzero(~found.thinned.kept)[0])
    mapper.graph.add_node(mapper.graph.poses[-1])
    mapper.graph.add_edge(removed, mapper.graph.node_count - 1, (0.1, 0.0, 0.0), np.eye(3), EdgeKind.ODOMETRY)
    count = len(mapper.key_frames)
    mapper.apply(found)
    assert (len(mapper.key_frames), mapper.thinnings) == (count, 0)
    assert mapper.next_work() is not None


def test_key_frames_that_are_drawn_during_a_thinning_are_not_drawn_again():
    mapper = LiveMapper(LASER, closures=None, lifelong=LifelongParameters(pass_distance=4.0, least_new_frames=150))
    found = thinning_after_five_laps(mapper)
    for k in range(150, 155):
        go_round(mapper, k)
    beams = mapper.draw()._ended.sum()
    mapper.apply(found._replace(canvas=None))  # the map of what is left would be too large
    assert len(mapper.key_frames) < 155
    assert mapper.draw()._ended.sum() == beams


@pytest.mark.parametrize(("wide", "method"), [(False, Robust.SCALING), (True, Robust.GRADUATED)])
def test_a_robot_that_was_far_from_its_place_gets_there_without_a_good_start(mapper, monkeypatch, wide, method):
    used, solve = [], mapper._solver.solve
    agreeing = [closure(30, 2, 20.0, wide=wide), closure(32, 4, 20.0, wide=wide)]
    monkeypatch.setattr(mapper._search, "search", lambda *_: Searched(agreeing))
    monkeypatch.setattr(
        mapper._solver, "solve", lambda graph, options: used.append(options.robust) or solve(graph, options)
    )
    monkeypatch.setattr(background_work, "divide", lambda *_: (agreeing, []))
    closed = mapper.next_work()(never)
    assert used == [method]
    assert len(closed.trusted) == 2
