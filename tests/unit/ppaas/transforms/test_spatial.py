"""Rigid transforms compose like matrices, and the latest transforms are found for any input."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.tf2_msgs import MAX_FRAMES
from ppaas.robot_model.shapes import placed
from ppaas.transforms.planar import transform_message
from ppaas.transforms.spatial import LatestFrames, Rigid

METRES = st.floats(-10.0, 10.0)
TURNS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1)
RIGIDS = st.builds(
    lambda t, q: Rigid.of(Transform(Vector3(*t), Quaternion(x=q[0], y=q[1], z=q[2], w=q[3]))),
    st.tuples(METRES, METRES, METRES),
    TURNS,
)


def matrix(rigid: Rigid) -> NDArray[np.float64]:
    made = np.eye(4)
    made[:3, :3] = Rotation.from_quat(rigid[3:]).as_matrix()
    made[:3, 3] = rigid[:3]
    return made


@given(RIGIDS, RIGIDS)
def test_composition_and_inverse_agree_with_matrices(a, b):
    np.testing.assert_allclose(matrix(a @ b), matrix(a) @ matrix(b), atol=1e-9)
    np.testing.assert_allclose(matrix(a.inverse() @ a @ b), matrix(b), atol=1e-9)


@given(RIGIDS, RIGIDS)
def test_distance_and_angle_between_two_transforms(a, b):
    turn = (Rotation.from_quat(a[3:]).inv() * Rotation.from_quat(b[3:])).magnitude()
    assert a.angle_to(b) == pytest.approx(turn, abs=1e-6)
    assert a.distance_to(b) == pytest.approx(np.linalg.norm(np.subtract(a[:3], b[:3])))


@pytest.mark.parametrize(
    ("rpy", "tilt"), [((0, 0, 2.0), 0.0), ((math.pi, 0, 1.0), 0.0), ((0, 0.3, 1.0), 0.3), ((math.pi / 2, 0, 0), 1.571)]
)
def test_tilt_is_that_of_the_plane_whichever_side_is_up(rpy, tilt):
    assert placed((0, 0, 0), rpy).tilt == pytest.approx(tilt, abs=1e-3)


def frames_with(*edges: tuple[str, str, Pose2D]) -> LatestFrames:
    frames = LatestFrames()
    frames.hear(transform_message(parent, child, pose, Time(1)) for parent, child, pose in edges)
    return frames


def test_lookup_works_up_and_down_the_tree_with_or_without_slashes():
    a, b, c = Pose2D(1.0, 2.0, 0.3), Pose2D(0.5, 0.0, -1.0), Pose2D(-1.0, 0.0, 2.0)
    frames = frames_with(("map", "/odom", a), ("odom", "base_link", b), ("/map", "dock", c))
    for target, source, pose in (("map", "base_link", a @ b), ("base_link", "dock", (a @ b).inverse() @ c)):
        found = frames.lookup(target, source)
        assert (found.x, found.y) == pytest.approx((pose.x, pose.y))
        assert 2.0 * math.atan2(found.qz, found.qw) == pytest.approx(pose.theta)
    assert frames.lookup("map", "map") == Rigid()


def test_newest_transform_of_a_frame_replaces_its_parent():
    frames = frames_with(("map", "a", Pose2D(1.0, 0.0)), ("other", "a", Pose2D(2.0, 0.0)))
    assert frames.lookup("other", "a").x == 2.0
    with pytest.raises(TransformError, match="unknown frame 'map'; known: a, other"):
        frames.lookup("map", "a")


def test_root_and_connection_of_frames():
    frames = frames_with(("odom", "base_link", Pose2D(0, 0)), ("base_link", "laser", Pose2D(0, 0)))
    assert frames.root("laser") == "odom"
    assert frames.root("crane") == "crane"
    assert frames.connected("laser", "odom")
    assert not frames.connected("laser", "crane")


def test_loops_and_invalid_transforms_are_ignored_without_hanging():
    frames = frames_with(("a", "b", Pose2D(1.0, 0.0)), ("b", "a", Pose2D(1.0, 0.0)), ("self", "self", Pose2D(0.0, 0.0)))
    with pytest.raises(TransformError):
        frames.lookup("map", "a")
    with pytest.raises(TransformError):
        frames.lookup("map", "self")
    frames.hear([transform_message("map", "good", Pose2D(1.0, 0.0), Time(1))])
    nowhere = Transform(Vector3(math.nan), Quaternion(z=0.0, w=1.0))
    for bad in (nowhere, Transform(Vector3(), Quaternion(z=0.0, w=0.0))):
        frames.hear([TransformStamped(Header(frame_id="map"), "good", bad)])
        assert frames.lookup("map", "good").x == 1.0


def test_number_of_frames_is_limited_and_known_ones_are_updated():
    frames = frames_with(*[("map", f"f{number}", Pose2D(0.0, 0.0)) for number in range(MAX_FRAMES + 1)])
    with pytest.raises(TransformError):
        frames.lookup("map", f"f{MAX_FRAMES}")
    frames.hear([transform_message("map", "f0", Pose2D(5.0, 0.0), Time(2))])
    assert frames.lookup("map", "f0").x == 5.0
