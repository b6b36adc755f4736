"""Node ``grid_slam``, on a simulated drive."""

import math

import msgspec
import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidParameter, NotFound, QuotaExceeded, TransformError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.parameters import SlamParameters
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN
from ppaas.messages.base.std_msgs import String
from ppaas.messages.slam_toolbox import SaveMapRequest
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.grid_slam.parameters import LIVE_KEY_FRAMES, GridSlamParameters
from ppaas.parameters import read_parameters
from ppaas.transforms.planar import CACHE_TIME
from tests.support.world.mapping_robot import HeldJobs, MappingRobot
from tests.support.world.ring_drive import ring_drive

WHOLE = len(ring_drive().log)


def status(robot: MappingRobot) -> str:
    latched = robot.graph.latched("grid_slam/status")
    return latched.data if isinstance(latched, String) else ""


@pytest.fixture(scope="module")
def mapped() -> MappingRobot:
    robot = MappingRobot(ring_drive())
    robot.step(WHOLE)
    return robot


def test_the_robot_is_localized_in_its_map(mapped):
    assert mapped.true_error() < 0.05
    assert len(mapped.heard["pose"]) == len(mapped.heard["entropy"]) == WHOLE
    assert mapped.heard["pose"][-1].header.frame_id == "map"
    assert mapped.node._mapper.closed > 3


def test_the_first_key_frame_stays_where_it_is(mapped):
    first = mapped.odometry(0) @ mapped.drive.log.geometry.mount
    np.testing.assert_allclose(mapped.node._mapper.key_frames.poses[0], first, atol=1e-9)


def test_the_map_shows_the_ring(mapped):
    grid, true = mapped.map(), mapped.drive.true
    to_map = mapped.odometry(0) @ Pose2D(*true[0].tolist()).inverse()
    for (x, y), value in (((6.0, 0.0), OCCUPIED), ((12.0, 6.0), OCCUPIED), ((6.0, 1.2), FREE), ((6.0, 4.0), UNKNOWN)):
        at = to_map @ Pose2D(x, y)
        row, column = grid.info.cell_of(at.x, at.y)
        assert (grid.data[row - 1 : row + 2, column - 1 : column + 2] == value).any(), (x, y)


def test_updates_keep_the_map_of_a_client_current(mapped):
    mapped.clock.advance(1.0)
    mapped.graph.run_due()
    displayed, grid = mapped.displayed(), mapped.map()
    assert displayed.info == grid.info
    np.testing.assert_array_equal(displayed.data, grid.data)
    assert len(mapped.heard["map_updates"]) > 20
    cells = sum(update.width * update.height for update in mapped.heard["map_updates"])
    assert cells / len(mapped.heard["map_updates"]) < 0.5 * grid.data.size
    assert mapped.heard["map_metadata"][-1].width == grid.info.width


def test_changes_are_published_every_second_while_the_robot_drives(mapped):
    stamps = {message.header.stamp.seconds() for topic in ("map", "map_updates") for message in mapped.heard[topic]}
    gaps = np.diff(sorted(stamps))
    assert np.quantile(gaps, 0.9) <= 1.3


def test_scans_wait_until_the_node_is_prepared(caplog):
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), jobs, prepare=lambda: None)
    robot.step(3)
    assert "pose" not in robot.heard
    assert status(robot) == "mapping is being prepared: scans are used in a moment"
    jobs.release()
    assert len(robot.heard["pose"]) == 3
    robot.step(2)
    assert len(robot.heard["pose"]) == 5
    assert status(robot) == ""
    assert caplog.messages == []


def test_scans_do_not_wait_for_what_only_closures_need():
    jobs, prepared = HeldJobs(), []
    robot = MappingRobot(
        ring_drive(), jobs, prepare=lambda: prepared.append("scans"), prepare_closures=lambda: prepared.append("loops")
    )
    robot.step(3)
    jobs.release()
    assert (prepared, len(robot.heard["pose"])) == (["scans"], 3)
    jobs.release()
    robot.step()
    assert (prepared, jobs.held) == (["scans", "loops"], [])


def test_scans_from_before_the_transforms_that_tf_keeps_are_not_used():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), jobs, prepare=lambda: None)
    robot.step(100)
    jobs.release()
    lasted = robot.drive.log.stamps[99] - robot.drive.log.stamps[:100]
    assert len(robot.heard["pose"]) == np.count_nonzero(lasted <= CACHE_TIME)


def test_scans_are_used_although_preparing_fails(caplog):
    def fail() -> None:
        raise Unavailable("no space for kernels")

    robot = MappingRobot(ring_drive(), prepare=fail)
    robot.step()
    assert len(robot.heard["pose"]) == 1
    assert caplog.messages == ["kernels of mapping are loaded at their first call: no space for kernels"]


def test_closures_are_applied_while_scans_go_on():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), jobs)
    for number in range(WHOLE):
        robot.step()
        assert len(robot.heard["pose"]) == number + 1, "a scan waits for a job"
        assert len(jobs.held) <= 1
        if number % 25 == 24:
            mapper, before = robot.node._mapper, robot.in_map
            closed, poses = mapper.closed, mapper.key_frames.poses.copy()
            jobs.release()
            if mapper.closed > closed:
                np.testing.assert_array_equal(mapper.key_frames.poses[0], poses[0])
                np.testing.assert_array_equal(mapper.graph.poses, mapper.key_frames.poses)
                assert robot.in_map == before, "tf changes with the next scan"
    assert robot.node._mapper.closed > 3
    while jobs.held:
        jobs.release()
    robot.next -= 1
    robot.step()
    assert robot.true_error() < 0.06


def test_key_frames_made_during_a_search_are_carried_along():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), jobs)
    while True:
        robot.step(20)
        mapper = robot.node._mapper
        known, before, closed = len(mapper._running.frames) if mapper._running else 0, mapper.key_frames.poses.copy(), 0
        robot_before, closed = robot.node._map_to_odom, mapper.closed
        jobs.release()
        if mapper.closed > closed and known < len(before):
            break
    after = mapper.key_frames.poses
    assert np.abs(after - before).max() > 1e-3
    anchor, moved = Pose2D(*before[known - 1].tolist()), Pose2D(*after[known - 1].tolist())
    for old, new in zip(before[known:].tolist(), after[known:].tolist(), strict=True):
        np.testing.assert_allclose(moved.inverse() @ Pose2D(*new), anchor.inverse() @ Pose2D(*old), atol=1e-9)
    motion = moved @ anchor.inverse()
    np.testing.assert_allclose(robot.node._map_to_odom, motion @ robot_before, atol=1e-9)


def test_a_map_cleared_during_a_search_is_not_moved_by_its_result():
    jobs = HeldJobs()
    robot = MappingRobot(ring_drive(), jobs)
    robot.step(100)
    assert jobs.held
    robot.call("clear")
    assert robot.graph.latched("map") is None
    assert robot.call("dynamic_map").map.info.width == 0
    jobs.release()
    robot.step(5)
    assert len(robot.node._mapper.key_frames) <= 3


def test_pause_keeps_the_transform_and_makes_no_key_frames():
    robot = MappingRobot(ring_drive())
    robot.step(20)
    count = len(robot.node._mapper.key_frames)
    assert robot.call("pause").status is True
    robot.step(20)
    assert len(robot.node._mapper.key_frames) == count
    assert len(robot.heard["pose"]) == 20
    assert robot.frames.tree.newest("odom") == pytest.approx(robot.clock() + 0.2)
    assert "paused" in status(robot)
    assert robot.call("pause").status is False
    robot.step(20)
    assert status(robot) == ""
    assert robot.true_error() < 0.1


def test_scans_may_be_throttled():
    robot = MappingRobot(ring_drive(), throttle_scans=3)
    robot.step(30)
    assert len(robot.heard["pose"]) == 10
    slow = MappingRobot(ring_drive(), minimum_time_interval=0.5)
    slow.step(30)
    assert len(slow.heard["pose"]) == 10


def test_a_period_of_zero_publishes_no_transform():
    robot = MappingRobot(ring_drive(), transform_publish_period=0.0)
    robot.step(3)
    assert robot.frames.tree.newest("odom") is None


def test_maps_are_saved_by_the_function_given():
    saved = {}

    def save(name, grid, done):
        saved[name] = grid
        done(None if name else NotFound("map", name))

    robot = MappingRobot(ring_drive(), save=save)
    request = SaveMapRequest(String("office-2"))
    assert robot.call("save_map", request).result == 1
    robot.step(10)
    assert robot.call("save_map", request).result == 0
    np.testing.assert_array_equal(saved["office-2"].data, robot.map().data)
    with pytest.raises(NotFound):
        robot.call("save_map", SaveMapRequest(String("")))
    with pytest.raises(Unavailable, match="dynamic_map"):
        MappingRobot(ring_drive()).call("save_map", request)


# -- bad input ---------------------------------------------------------------------------------------------------------


def test_a_scan_with_other_beams_is_refused():
    robot = MappingRobot(ring_drive())
    robot.step(3)
    robot.clock.advance(0.2)
    robot.odom(robot.odometry(3))
    scan = robot.scan_message(3)
    half = msgspec.structs.replace(scan, ranges=scan.ranges[::2], angle_increment=2.0 * scan.angle_increment)
    with pytest.raises(InvalidInput, match=r"45 ranges .* scans with 90 .* call 'clear'"):
        robot.graph.inject("scan", half)
    assert status(robot).startswith("scans are refused: the scan has 45 ranges")
    with pytest.raises(InvalidInput):
        robot.graph.inject("scan", msgspec.structs.replace(scan, ranges=[]))
    assert len(robot.heard["pose"]) == 3
    robot.graph.inject("scan", scan)
    assert (len(robot.heard["pose"]), status(robot)) == (4, "")


@pytest.mark.parametrize("count", [88, 92])
def test_some_beams_more_or_less_are_usual(count):
    robot = MappingRobot(ring_drive())
    robot.step(3)
    robot.clock.advance(0.2)
    robot.odom(robot.odometry(3))
    scan = robot.scan_message(3)
    robot.graph.inject("scan", msgspec.structs.replace(scan, ranges=[*scan.ranges, 1.0, 1.0][:count]))
    assert len(robot.heard["pose"]) == 4


def test_another_laser_is_refused():
    robot = MappingRobot(ring_drive())
    robot.step(2)
    robot.odom(robot.odometry(2))
    scan = robot.scan_message(2)
    scan.header.frame_id = "base_link"
    with pytest.raises(InvalidInput, match="of laser 'laser': 'base_link' is not used"):
        robot.graph.inject("scan", scan)
    scan.header.frame_id = "velodyne"
    with pytest.raises(TransformError, match="velodyne"):
        robot.graph.inject("scan", scan)


def test_beams_without_a_reading_leave_the_map_right():
    missing = (0.0, math.inf, -math.inf, math.nan, -1.0, 1e30, None)
    robot = MappingRobot(ring_drive())
    whole = robot.scan_message

    def with_gaps(number, stamp=None):
        scan = whole(number, stamp)
        ranges = [missing[i % 7] if i % 4 == 0 else reading for i, reading in enumerate(scan.ranges)]
        return msgspec.structs.replace(scan, ranges=ranges)

    robot.scan_message = with_gaps
    robot.step(60)
    assert robot.true_error() < 0.05
    assert status(robot) == ""


def test_odometry_that_never_changes_is_none():
    robot = MappingRobot(ring_drive())
    robot.odometry = lambda _number: Pose2D(1.0, 2.0, 0.5)
    robot.step(120)
    assert robot.true_error() < 0.05


def test_without_odometry_scans_wait():
    robot = MappingRobot(ring_drive())
    robot.graph.inject("scan", robot.scan_message(0))
    assert "wait for odometry" in status(robot)
    assert "pose" not in robot.heard
    robot.odom(robot.odometry(0))
    assert (len(robot.heard["pose"]), status(robot)) == (1, "")


def test_a_clock_that_is_set_back_goes_on():
    robot = MappingRobot(ring_drive())
    robot.step(20)
    for number in range(20, 40):
        robot.clock.advance(0.2)
        robot.odom(robot.odometry(number), robot.clock() - 300.0)
        robot.graph.inject("scan", robot.scan_message(number, robot.clock() - 300.0))
    assert len(robot.heard["pose"]) == 40
    apart = Pose2D(*robot.poses()[19].tolist()).inverse() @ Pose2D(*robot.poses()[39].tolist())
    true = Pose2D(*robot.drive.true[19].tolist()).inverse() @ Pose2D(*robot.drive.true[39].tolist())
    np.testing.assert_allclose(apart, true, atol=0.05)


def test_scans_ahead_of_the_odometry_are_told():
    robot = MappingRobot(ring_drive())
    robot.step(3)
    robot.graph.inject("scan", robot.scan_message(3, robot.clock() + 60.0))
    robot.odom(robot.odometry(3), robot.clock() + 0.1)
    assert "60.0 s ahead of the newest odometry" in status(robot)


def test_odometry_that_is_reset_does_not_move_the_robot():
    robot = MappingRobot(ring_drive())
    robot.step(60)
    reset = robot.odometry(60).inverse()
    before = robot.in_map
    for number in range(60, 80):
        robot.clock.advance(0.2)
        robot.odom(reset @ robot.odometry(number))
        robot.graph.inject("scan", robot.scan_message(number))
    apart = before.inverse() @ Pose2D(*robot.poses()[-1].tolist())
    true = Pose2D(*robot.drive.true[59].tolist()).inverse() @ Pose2D(*robot.drive.true[79].tolist())
    np.testing.assert_allclose(apart, true, atol=0.05)


def test_a_full_map_refuses_scans_and_says_so():
    robot = MappingRobot(ring_drive(), max_key_frames=5)
    with pytest.raises(QuotaExceeded, match="max_key_frames"):
        robot.step(100)
    assert "max_key_frames" in status(robot)
    assert len(robot.node._mapper.key_frames) == 5
    assert robot.map().data.max() == OCCUPIED


def test_a_map_that_would_be_too_large_is_told(monkeypatch):
    monkeypatch.setattr("ppaas.mapping.live.map_canvas.MOST_CELLS", 200 * 200)
    robot = MappingRobot(ring_drive())
    robot.step(40)
    assert "choose a coarser resolution" in status(robot)
    assert len(robot.heard["pose"]) == 40


def read(**given) -> GridSlamParameters:
    return read_parameters(GridSlamParameters, "grid_slam", given)


def test_defaults_are_those_of_offline_mapping():
    assert read().front_end() == SlamParameters(max_key_frames=LIVE_KEY_FRAMES)
    assert read().closures() == ClosureParameters()
    assert read().drawing() == DrawingSettings()
    assert read().frames() == FrameNames()


def test_names_of_gmapping_are_read():
    given = read(
        delta=0.1, linearUpdate=0.5, angularUpdate=0.4, maxUrange=12, occ_thresh=0.25, temporalUpdate=-1.0, srr=0.2,
        base_frame="base_footprint", odom_frame="/odom", map_frame="office", throttle_scans=2, map_update_interval=2,
    )  # fmt: skip
    front = given.front_end()
    assert (front.resolution, front.max_laser_range, front.srr) == (0.1, 12, 0.2)
    assert (front.minimum_travel_distance, front.minimum_travel_heading) == (0.5, 0.4)
    assert given.drawing() == DrawingSettings(0.1, 2, 0.25)
    assert given.least_interval == 0.0
    assert given.frames() == FrameNames("odom", "base_footprint", "office")


def test_names_of_slam_toolbox_are_read():
    given = read(
        resolution=0.02, max_laser_range=20.0, minimum_time_interval=0.5, loop_search_maximum_distance=3.0,
        loop_match_minimum_chain_size=10, do_loop_closing=True, paused_new_measurements=True,
    )  # fmt: skip
    assert given.closures() == ClosureParameters(
        loop_search_maximum_distance=3.0, loop_match_minimum_chain_size=10, checked_scans=10
    )
    assert (given.drawing().resolution, given.least_interval) == (0.02, 0.5)
    assert read(do_loop_closing=False).closures() is None


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"particles": 30}, "unknown field `particles`; known: .*angularUpdate.*throttle_scans"),
        ({"throttle_scans": 0}, "throttle_scans must be above 0"),
        ({"delta": -0.05}, "delta must be above 0"),
        ({"maxUrange": 0.01}, "minimum_laser_range must be below max_laser_range"),
        ({"occ_thresh": 25.0}, "occ_thresh, must be at most 1"),
        ({"map_update_interval": float("nan")}, "map_update_interval must be finite"),
        ({"loop_match_minimum_response_coarse": 1.5}, "loop_match_minimum_response_coarse"),
        ({"map_frame": 3}, "map_frame"),
    ],
)
def test_wrong_parameters_are_refused(given, text):
    with pytest.raises(InvalidParameter, match=text):
        read(**given)
