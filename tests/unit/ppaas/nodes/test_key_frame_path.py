"""Key frames as a path: what ``grid_slam`` publishes, and what is read from messages."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.key_frame_path import key_frames_of
from tests.support.world.mapping_robot import START, MappingRobot
from tests.support.world.ring_drive import ring_drive


def test_key_frames_of_grid_slam_are_published_while_somebody_subscribes():
    robot, heard = MappingRobot(ring_drive()), []
    robot.step(2)
    robot.graph.tap("key_frames", lambda _, message: heard.append(message))
    while not heard:
        robot.step()
    key_frames = key_frames_of(heard[-1])
    assert len(key_frames) == 2
    assert key_frames.stamps[0] == pytest.approx(START)
    assert key_frames.poses[-1] == pytest.approx(robot.poses()[-1], abs=1e-6)
    sent = key_frames_of(decode(Path, encode(heard[-1].to_message())))
    assert sent.stamps == pytest.approx(key_frames.stamps)
    assert sent.poses == pytest.approx(key_frames.poses)
    robot.call("clear")
    assert not len(key_frames_of(heard[-1]))


def path(*stamped):
    poses = [PoseStamped(Header(stamp=Time.of(stamp)), Pose.of(pose)) for stamp, pose in stamped]
    return Path(Header(), poses)


@pytest.mark.parametrize(
    "wrong",
    [
        path((2.0, Pose2D(0.0, 0.0)), (1.0, Pose2D(0.0, 0.0))),
        path((1.0, Pose2D(np.nan, 0.0))),
        Empty(),
    ],
)
def test_key_frames_that_are_not_finite_or_not_in_order_are_refused(wrong):
    with pytest.raises(InvalidInput):
        key_frames_of(wrong)
