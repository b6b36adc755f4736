"""Listener of tf."""

import math

import pytest

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import FrameListener
from ppaas.transforms.planar import transform_message


def test_silence_counts_from_the_arrival_not_from_the_stamp():
    frames = FrameListener()
    assert frames.silence("base_link", 5.0) == math.inf
    frames.hear("tf", TFMessage([transform_message("odom", "base_link", Pose2D(0, 0, 0), Time(10**9))]), 10.0)
    assert frames.silence("base_link", 12.5) == 2.5


def test_tilted_frame_is_skipped_and_others_are_taken():
    frames = FrameListener()
    camera = TransformStamped(
        Header(frame_id="base_link"), "camera", Transform(Vector3(), Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5))
    )
    frames.hear("tf", TFMessage([camera, transform_message("odom", "base_link", Pose2D(1, 0, 0), Time(1))]), 0.0)
    assert frames.tree.frames() == ("base_link", "odom")


def test_invalid_transform_is_refused():
    broken = transform_message("odom", "base_link", Pose2D(math.nan, 0, 0), Time(1))
    with pytest.raises(TransformError):
        FrameListener().hear("tf", TFMessage([broken]), 0.0)
