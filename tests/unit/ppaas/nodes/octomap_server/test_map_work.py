"""Log of the 3D map."""

import base64

import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.octomap import parse_octomap
from ppaas.messages.octomap_msgs import GetOctomapFileRequest
from ppaas.nodes.octomap_server.node import LOG_PERIOD
from tests.support.world.cloud_robot import START, CloudRobot, wall
from tests.support.world.mapping_robot import HeldJobs

HERE = Pose2D(0.0, 0.0)


def stored(robot: CloudRobot, entries: dict[int, bytes] | None = None) -> dict[int, bytes]:
    """Return the log of a robot, some seconds later."""
    robot.clock.advance(LOG_PERIOD)
    robot.graph.run_due()
    change = robot.node.log_change()
    entries = dict(entries or {})
    if change is not None:
        entries |= dict(change.entries)
        for number in change.obsolete:
            del entries[number]
    return entries


def restored(entries: dict[int, bytes], **options) -> CloudRobot:
    robot = CloudRobot(**options)
    robot.clock.advance(100.0)
    robot.node.restore_log([LogEntry(*entry) for entry in sorted(entries.items())])
    return robot


@pytest.fixture
def mapped() -> CloudRobot:
    """Return a robot that has seen a wall from its first key frame."""
    robot = CloudRobot()
    robot.move(HERE, correction=None)
    robot.key_frames((START, HERE))
    robot.send(wall(2.05))
    return robot


def test_another_node_has_the_map_and_goes_on_with_it(mapped):
    entries = stored(mapped)
    assert stored(mapped, entries) == entries
    robot = restored(entries)
    np.testing.assert_array_equal(robot.occupied(), mapped.occupied())
    assert stored(robot, entries).keys() == entries.keys()
    robot.move(HERE)
    robot.key_frames((START, HERE), (robot.clock(), HERE))
    robot.send(wall(1.55))
    assert set(np.round(robot.occupied()[:, 0], 2)) == {1.55, 2.05}
    again = restored(stored(robot, entries))
    np.testing.assert_array_equal(again.occupied(), robot.occupied())


def test_a_loop_that_is_closed_later_moves_the_map_of_before(mapped):
    robot = restored(stored(mapped))
    robot.key_frames((START, Pose2D(0.0, 1.0)))
    assert robot.occupied()[:, 1].mean() == pytest.approx(1.0, abs=0.06)


def test_key_frames_that_have_moved_since_the_map_was_logged_move_it(mapped):
    jobs = HeldJobs()
    robot = restored(stored(mapped), worker=jobs)
    robot.key_frames((START, Pose2D(0.0, 1.0)))
    while jobs.held:
        jobs.release()
    assert robot.node._work._map.submaps[0].motion == Pose2D(0.0, 1.0, 0.0)


def test_a_file_is_that_of_the_key_frames_requested(mapped):
    moved = GetOctomapFileRequest(0, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    file = base64.b64decode(mapped.call("octomap_server/file", moved).data)
    tree = parse_octomap(file)
    centres = (tree.corners[tree.occupied].astype(float) - 32768 + 0.5) * tree.resolution
    assert centres[:, 1].mean() == pytest.approx(1.0, abs=0.06)
    assert abs(mapped.occupied()[:, 1].mean()) < 0.06
    for wrong in ([0.0, 0.0], [0.0, 0.0, float("inf")], [0.0] * 6):
        with pytest.raises(InvalidInput):
            mapped.call("octomap_server/file", GetOctomapFileRequest(0, [0.0, 0.0, 0.0], wrong))


def test_a_log_that_cannot_be_read_is_reported_and_mapping_begins_again(mapped, caplog):
    entries = stored(mapped)
    entries[0] = entries[0][:-1] + b"?"
    robot = restored(entries)
    assert robot.status == "the 3D map so far is lost: the log of the 3D map is damaged: map the place again"
    assert "the 3D map that the robot was making is lost" in caplog.text
    robot.move(HERE)
    robot.send(wall(1.55))
    assert robot.status.startswith("the 3D map so far is lost")
    again = restored(stored(robot, entries))
    np.testing.assert_array_equal(again.occupied(), robot.occupied())


def test_a_map_without_key_frames_is_kept_too():
    robot = CloudRobot()
    assert stored(robot) == {}
    robot.move(HERE)
    robot.send(wall(2.05))
    entries = stored(robot)
    np.testing.assert_array_equal(restored(entries).occupied(), robot.occupied())
    robot.call("octomap_server/reset")
    assert stored(robot, entries) == {}
