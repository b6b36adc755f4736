"""Maps of ``grid_slam`` that are kept: logs from which another node continues, and pose graphs."""

import base64

import numpy as np
import pytest

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import InvalidGraph, InvalidInput, InvalidParameter, NotFound, TransformError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.mapping.serialization.records import RecordKind, unpack_records
from ppaas.messages import geometry_msgs
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.slam_toolbox import (
    DeserializePoseGraphRequest,
    GetPoseGraphRequest,
    MatchType,
    SaveMapRequest,
    SerializePoseGraphRequest,
)
from ppaas.nodes import file_pages
from ppaas.nodes.grid_slam import logbook
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.posegraph_services import PoseGraphStore
from ppaas.nodes.jobs import run_inline
from ppaas.nodes.key_frame_path import key_frames_of
from tests.support.world.mapping_robot import HeldJobs, MappingRobot
from tests.support.world.ring_drive import ring_drive

HALF = len(ring_drive().log) // 2


class Kept:
    """What is stored of a robot: the checkpoint and the log."""

    def __init__(self):
        self.state, self.entries = None, {}

    def save(self, robot):
        change = robot.node.log_change()
        self.state = robot.node.checkpoint()
        if change is not None:
            self.entries |= dict(change.entries)
            for number in change.obsolete:
                del self.entries[number]

    def restored(self, worker=run_inline, **parameters):
        """Return a robot that continues."""
        robot = MappingRobot(ring_drive(), worker, **parameters)
        if self.state is not None:
            robot.node.restore(self.state)
        if self.entries:
            robot.node.restore_log([LogEntry(*entry) for entry in sorted(self.entries.items())])
        return robot


def status(robot):
    latched = robot.graph.latched("grid_slam/status")
    return "" if latched is None else latched.data


@pytest.fixture(scope="module")
def driven():
    """Return a robot in the middle of its drive, and what is stored of it."""
    robot, kept = MappingRobot(ring_drive()), Kept()
    for _ in range(HALF):
        robot.step()
        if robot.node.has_log_change:
            kept.save(robot)
        assert not robot.node.has_log_change
    kept.save(robot)
    return robot, kept


@pytest.fixture(scope="module")
def file(driven):
    """Return the file of the robot's pose graph."""
    files = {}
    robot, _ = driven
    robot.node._graphs._store = PoseGraphStore(lambda name, data, done: (files.update({name: data}), done(None)))
    robot.call("serialize_map", SerializePoseGraphRequest("ring"))
    return files["ring"]


def test_another_node_continues_from_the_log_as_if_nothing_had_happened(driven):
    robot, kept = driven
    restored = kept.restored()
    mapper, before = restored.node._mapper, robot.node._mapper
    np.testing.assert_array_equal(mapper.key_frames.poses, before.key_frames.poses)
    np.testing.assert_array_equal(mapper.graph.edges.first.sum(), before.graph.edges.first.sum())
    assert (mapper.closed, mapper.searched) == (before.closed, before.searched)
    np.testing.assert_allclose(restored.node._map_to_odom, robot.node._map_to_odom, atol=1e-9)
    assert (restored.map().data != robot.map().data).mean() < 1e-3  # points are rounded
    restored.next = HALF
    restored.step(HALF)
    assert restored.true_error() < 0.06
    assert restored.node._mapper.closed > before.closed


def test_the_robot_has_its_pose_while_its_map_is_restored(driven):
    robot, kept = driven
    jobs = HeldJobs()
    restored = kept.restored(worker=jobs)
    restored.next = HALF
    restored.step(3)
    assert restored.in_map.distance_to(robot.node._map_to_odom @ restored.odometry(HALF + 2)) < 1e-6
    assert status(restored) == "the map is being restored: scans are used in a moment"
    assert "pose" not in restored.heard
    again = Kept()
    again.state, again.entries = restored.node.checkpoint(), dict(restored.node.whole_log().entries)
    assert (again.state, again.entries, restored.node.log_change()) == (kept.state, kept.entries, None)
    answers = []
    restored.graph.call("dynamic_map", Empty(), answers.append)
    jobs.release()
    assert len(restored.heard["pose"]) == 3, "the scans have waited"
    assert status(restored) == ""
    assert answers[0].map.info.width > 0
    restored.step(HALF - 3)
    assert restored.true_error() < 0.06


@pytest.mark.parametrize("rewritten", [False, True])
def test_another_node_knows_the_times_of_all_key_frames(driven, rewritten):
    robot, kept = driven
    restored, heard = (all_anew(kept) if rewritten else kept).restored(), []
    restored.graph.tap("key_frames", lambda _, message: heard.append(key_frames_of(message)))
    restored.next = HALF
    times = robot.node._logbook.times
    while not heard or len(heard[-1].stamps) == len(times.stamps):
        restored.step()
    assert heard[-1].stamps.tolist()[:-1] == pytest.approx(times.stamps)
    assert len(times.stamps) == len(robot.node._mapper.key_frames)


def all_anew(kept):
    """Return what is stored after another node has replaced all entries of the log."""
    again, robot = Kept(), kept.restored()
    change = robot.node.whole_log()
    again.state, again.entries = robot.node.checkpoint(), dict(change.entries)
    assert set(change.obsolete) == set(kept.entries)
    return again


def test_times_of_key_frames_are_few_entries(monkeypatch):
    monkeypatch.setattr(logbook, "FOLD", 3)
    robot, kept = MappingRobot(ring_drive()), Kept()
    for _ in range(30):
        robot.step()
        kept.save(robot)
        entries = [data for data in kept.entries.values() if next(unpack_records(data))[1].kind == RecordKind.TIMES]
        assert len(entries) <= 3
    assert kept.restored().node._logbook.times.stamps == robot.node._logbook.times.stamps
    robot.node._logbook.times.renumber({0: 0})
    kept.save(robot)
    assert kept.restored().node._logbook.times.numbers == [0]


def test_a_call_that_fails_after_the_map_was_restored_is_answered(driven):
    _, kept = driven
    jobs, answers = HeldJobs(), []
    restored = kept.restored(worker=jobs)
    restored.graph.call("save_map", SaveMapRequest(), answers.append)
    initial_pose(restored, Pose2D(0.0, 0.0, 0.0))
    assert answers == []
    jobs.release()
    assert isinstance(answers[0], Unavailable)
    assert restored.node._mapper._tracker.is_placing


def test_a_node_that_moves_while_its_map_is_restored_takes_it_along(driven):
    _, kept = driven
    restored = kept.restored(worker=HeldJobs())
    moved = Kept()
    moved.entries = dict(restored.node.whole_log().entries)
    moved.state = restored.graph.remove("grid_slam")
    assert len(moved.restored().node._mapper.key_frames) == len(kept.restored().node._mapper.key_frames)


def test_a_checkpoint_is_small_while_the_log_grows(driven):
    _, kept = driven
    assert len(kept.state) < 300
    assert sum(map(len, kept.entries.values())) > 50_000


def test_a_log_that_cannot_be_read_is_reported_and_mapping_begins_again(driven):
    _, kept = driven
    damaged = Kept()
    damaged.state, damaged.entries = kept.state, dict(kept.entries)
    number = sorted(damaged.entries)[3]
    damaged.entries[number] = damaged.entries[number][:-1] + b"?"
    robot = damaged.restored()
    robot.step(3)
    assert "the map so far is lost: the pose graph is damaged" in robot.graph.latched("grid_slam/status").data
    damaged.save(robot)
    assert len(damaged.restored().node._mapper.key_frames) == len(robot.node._mapper.key_frames)


def test_nothing_is_kept_before_the_first_scan_and_after_clear():
    robot = MappingRobot(ring_drive())
    assert (robot.node.checkpoint(), robot.node.log_change(), robot.node.has_log_change) == (None, None, False)
    robot.step()
    robot.call("clear")
    assert (robot.node.checkpoint(), robot.node.log_change()) == (None, None)


def test_a_map_that_was_cleared_does_not_come_back(driven):
    _, before = driven
    kept = Kept()
    kept.state, kept.entries = before.state, dict(before.entries)
    robot = kept.restored()
    robot.call("clear")
    assert robot.node.has_log_change
    kept.save(robot)
    assert not robot.node.has_log_change
    assert kept.restored().node._mapper is None
    robot.step(3)
    kept.save(robot)
    assert len(kept.restored().node._mapper.key_frames) == len(robot.node._mapper.key_frames)


def test_a_pose_graph_comes_in_pages(driven, file, monkeypatch):
    robot, _ = driven
    monkeypatch.setattr(file_pages, "PAGE", 40_000)
    numbers = robot.call("pose_graph", GetPoseGraphRequest())
    assert (numbers.key_frames, numbers.data) == (len(robot.node._mapper.key_frames), "")
    assert numbers.closures == robot.node._mapper.closed or numbers.closures > 0
    pages = b""
    while True:
        page = base64.b64decode(robot.call("pose_graph", GetPoseGraphRequest(len(pages))).data)
        if not page:
            break
        assert len(page) <= 40_000
        pages += page
    assert pages == file
    with pytest.raises(InvalidInput, match="begin at 0"):
        robot.call("pose_graph", GetPoseGraphRequest(7))


def test_a_robot_without_a_map_has_no_pose_graph():
    with pytest.raises(Unavailable, match="no map yet"):
        MappingRobot(ring_drive()).call("pose_graph", GetPoseGraphRequest())


def test_pose_graphs_are_neither_saved_nor_loaded_without_a_store():
    robot = MappingRobot(ring_drive())
    robot.step()
    with pytest.raises(Unavailable, match="ppaas robot map"):
        robot.call("serialize_map", SerializePoseGraphRequest("ring"))
    with pytest.raises(Unavailable, match="robot's file"):
        robot.call("deserialize_map", DeserializePoseGraphRequest("ring"))


def load(name):
    raise NotFound("map", name)


def test_a_published_map_is_continued_in_its_frame(driven, file):
    before, _ = driven
    count = len(before.node._mapper.key_frames)
    start = before.odometry(0)
    robot = MappingRobot(
        ring_drive(), graphs=PoseGraphStore(load=lambda name: file), map_file_name="ring",
        map_start_pose=(start.x + 0.1, start.y, start.theta),
    )  # fmt: skip
    robot.step(40)
    assert robot.true_error() < 0.05
    mapper = robot.node._mapper
    assert len(mapper.key_frames) > count
    np.testing.assert_allclose(mapper.key_frames.poses[:count], unpack_mapping(file).frames.poses, atol=0.01)
    kept = Kept()
    kept.save(robot)
    assert len(kept.restored().node._mapper.key_frames) == len(mapper.key_frames)


def test_localization_leaves_the_map_as_it_is(driven, file):
    robot = MappingRobot(
        ring_drive(), graphs=PoseGraphStore(load=lambda name: file), map_file_name="ring", mode="localization"
    )
    before = robot.map()
    robot.step(60)
    assert robot.true_error() < 0.05
    np.testing.assert_array_equal(robot.map().data, before.data)
    assert robot.node.log_change() is None
    restored = MappingRobot(
        ring_drive(), graphs=PoseGraphStore(load=lambda name: file), map_file_name="ring", mode="localization"
    )
    restored.node.restore(robot.node.checkpoint())
    restored.next = robot.next
    restored.step(20)
    assert restored.true_error() < 0.05


def test_a_published_map_takes_the_place_of_a_log_that_cannot_be_read(driven, file):
    given = {"graphs": PoseGraphStore(load=lambda name: file), "map_file_name": "ring"}
    robot, kept = MappingRobot(ring_drive(), **given), Kept()
    robot.step(3)
    kept.save(robot)
    whole = dict(kept.entries)
    kept.entries[1] = whole[1][:-1] + b"?"
    restored = kept.restored(**given)
    assert "the map so far is lost" in restored.node._problem()
    assert len(restored.node._mapper.key_frames) == len(unpack_mapping(file).frames)
    kept.save(restored)
    assert not set(whole) & set(kept.entries)
    assert len(kept.restored(**given).node._mapper.key_frames) == len(restored.node._mapper.key_frames)


def test_entries_that_localization_left_in_the_store_are_removed(driven, file):
    _, before = driven
    given = {"graphs": PoseGraphStore(load=lambda name: file), "map_file_name": "ring", "mode": "localization"}
    robot, kept = MappingRobot(ring_drive(), **given), Kept()
    kept.save(robot)
    kept.entries = dict(before.entries)
    restored = kept.restored(**given)
    assert not restored.node._mapper.keeps
    kept.save(restored)
    assert kept.entries == {}


def test_localization_in_a_map_that_was_continued_is_restored(driven, file):
    given = {"graphs": PoseGraphStore(load=lambda name: file), "map_file_name": "ring"}
    robot, kept = MappingRobot(ring_drive(), **given), Kept()
    robot.step(10)
    kept.save(robot)
    robot.call("deserialize_map", DeserializePoseGraphRequest("ring", MatchType.LOCALIZE_AT_POSE))
    kept.save(robot)
    restored = kept.restored(**given)
    assert not restored.node._mapper.keeps
    assert (restored.node.log_change(), restored.node.checkpoint()) == (None, kept.state)


def test_scans_go_on_while_a_map_is_loaded(driven, file):
    jobs, answers = HeldJobs(), []
    robot = MappingRobot(ring_drive(), jobs, graphs=PoseGraphStore(load=lambda name: file))
    robot.step(3)
    first = robot.node._mapper
    robot.graph.call("deserialize_map", DeserializePoseGraphRequest("ring"), answers.append)
    robot.graph.call("pose_graph", GetPoseGraphRequest(-1), answers.append)
    robot.step(3)
    assert (len(robot.heard["pose"]), answers) == (6, [])
    assert robot.node._mapper is first
    jobs.release()
    assert answers[0] == Empty()
    assert answers[1].key_frames == len(unpack_mapping(file).frames) == len(robot.node._mapper.key_frames)
    robot.step()
    assert len(robot.heard["pose"]) == 7


def test_a_map_that_cannot_be_loaded_leaves_the_current_one():
    robot = MappingRobot(ring_drive(), graphs=PoseGraphStore(load=lambda _: b"P5"))
    robot.step(3)
    first = robot.node._mapper
    with pytest.raises(InvalidGraph):
        robot.call("deserialize_map", DeserializePoseGraphRequest("ring"))
    assert robot.node._mapper is first
    assert robot.call("dynamic_map").map.info.width > 0


def test_deserialize_map_starts_where_it_is_told(driven, file):
    robot = MappingRobot(ring_drive(), graphs=PoseGraphStore(load=lambda name: file))
    start = robot.odometry(0)
    given = geometry_msgs.Pose2D(start.x, start.y, start.theta)
    robot.call("deserialize_map", DeserializePoseGraphRequest("ring", MatchType.LOCALIZE_AT_POSE, given))
    robot.step(10)
    assert robot.true_error() < 0.05
    assert robot.node.log_change() is None
    robot.call("deserialize_map", DeserializePoseGraphRequest("ring", MatchType.START_AT_FIRST_NODE))
    assert robot.node.checkpoint() is not None
    with pytest.raises(InvalidInput, match="three finite"):
        bad = geometry_msgs.Pose2D(float("nan"))
        robot.call("deserialize_map", DeserializePoseGraphRequest("ring", MatchType.START_AT_GIVEN_POSE, bad))


def test_an_initial_pose_places_the_robot(driven, file):
    robot = MappingRobot(
        ring_drive(),
        graphs=PoseGraphStore(load=lambda name: file),
        map_file_name="ring",
        map_start_pose=(30.0, 30.0, 0.0),
    )
    with pytest.raises(InvalidInput, match="publish the pose of the robot on 'initialpose'"):
        robot.step()
    initial_pose(robot, robot.odometry(0))
    robot.step(5)
    assert robot.true_error() < 0.05
    with pytest.raises(TransformError, match="must be in frame 'map'"):
        initial_pose(robot, Pose2D(0.0, 0.0, 0.0), "odom")


def initial_pose(robot, pose, frame="map"):
    stamped = PoseWithCovariance(Pose.of(pose), [0.0] * 36)
    robot.graph.inject("initialpose", PoseWithCovarianceStamped(Header(frame_id=frame), stamped))


def test_a_map_that_cannot_be_loaded_is_an_error_at_the_start():
    for graphs, error in ((PoseGraphStore(load=load), NotFound), (PoseGraphStore(load=lambda _: b"P5"), InvalidGraph)):
        with pytest.raises(error):
            MappingRobot(ring_drive(), graphs=graphs, map_file_name="ring")


@pytest.mark.parametrize(
    "given", [{"mode": "localization"}, {"map_file_name": "ring", "map_start_pose": (0.0, float("inf"), 0.0)}]
)
def test_parameters_that_contradict_each_other_are_refused(given):
    with pytest.raises(InvalidParameter):
        GridSlamParameters(**given)


STEPS = 30


def applied(log: dict[int, bytes], change: LogChange | None) -> dict[int, bytes]:
    """Return a stored log after a change."""
    if change is None:
        return log
    return {number: data for number, data in (log | dict(change.entries)).items() if number not in change.obsolete}


def moved(robot, log):
    """Return a robot whose node continues the map of another's."""
    another = MappingRobot(ring_drive())
    state = robot.node.checkpoint()
    another.node.restore(state)
    another.node.restore_log([LogEntry(*entry) for entry in sorted(log.items())])
    another.next = robot.next
    return another


def test_the_map_moves_with_its_node_and_the_stored_log_follows():
    robot = MappingRobot(ring_drive())
    robot.step(STEPS)
    stored = applied({}, robot.node.log_change())
    robot.step(STEPS)
    for _ in range(2):  # to the robot, and back to the cloud
        before = set(stored)
        stored = applied(stored, robot.node.whole_log())
        assert not before & set(stored), "entries have new numbers, so that no change of before applies to them"
        frames = len(robot.node._mapper.key_frames)
        robot = moved(robot, stored)
        assert len(robot.node._mapper.key_frames) == frames
        robot.step(STEPS)
        stored = applied(stored, robot.node.log_change())
    assert robot.true_error() < 0.05
    last = moved(robot, stored)
    np.testing.assert_array_equal(last.node._mapper.key_frames.poses, robot.node._mapper.key_frames.poses)


def test_a_node_without_a_map_has_no_log_to_move():
    assert MappingRobot(ring_drive()).node.whole_log() is None
