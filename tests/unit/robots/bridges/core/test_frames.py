"""Frames of a robot."""

from typing import Any

from robots.bridges.core.frames import HOLD, Frames


def transform(parent: str, child: str, x: float = 0.0) -> dict[str, Any]:
    return {"header": {"frame_id": parent}, "child_frame_id": child, "transform": {"translation": {"x": x}}}


def test_scans_wait_for_their_frame_but_not_for_ever() -> None:
    frames = Frames()
    frames.odometry({"header": {"frame_id": "odom"}, "child_frame_id": "base_footprint"})
    assert frames.may_send_scan("base_footprint", 0.0)
    assert frames.may_send_scan("", 0.0)
    assert not frames.may_send_scan("laser", 0.0)
    assert not frames.may_send_scan("laser", HOLD)
    assert frames.may_send_scan("laser", HOLD + 0.1), "the cloud may know it from the robot's model"
    other = Frames()
    assert not other.may_send_scan("laser", 0.0)
    other.sent([transform("base_link", "/laser")])
    assert other.may_send_scan("laser", 0.0)


def test_the_cloud_gets_the_parts_of_the_robot_and_not_what_it_knows_by_odometry() -> None:
    frames = Frames()
    all_of_them = [transform("odom", "base_link"), transform("map", "odom"), transform("base_link", "laser")]
    assert frames.upward(all_of_them, 0.0, static=False) == [all_of_them[2]]


def test_a_transform_that_has_not_changed_is_sent_once_a_second() -> None:
    frames = Frames()
    still, moved = [transform("base_link", "wheel")], [transform("base_link", "wheel", 0.1)]
    sent = [bool(frames.upward(still, now, static=False)) for now in (0.0, 0.5, 0.9, 1.0, 1.5)]
    assert sent == [True, False, False, True, False]
    assert frames.upward(moved, 1.6, static=False)
    assert frames.upward(still, 1.6, static=True), "what is published once is sent each time"


def test_the_robot_gets_the_place_of_its_odometry_in_the_map_alone() -> None:
    frames = Frames()
    frames.odometry({"header": {"frame_id": "tb3/odom"}, "child_frame_id": "tb3/base_link"})
    wanted = transform("map", "tb3/odom")
    assert frames.downward([wanted, transform("tb3/odom", "tb3/base_link"), transform("map", "person")]) == [wanted]


def test_a_robot_that_maps_without_odometry_gets_its_pose_in_the_map_and_does_not_send_it_back() -> None:
    frames = Frames()
    pose = [transform("map", "scan_odom"), transform("scan_odom", "base_footprint")]
    assert frames.downward([*pose, transform("base_link", "laser")]) == pose
    assert frames.in_map is None
    assert frames.upward(pose, 0.0, static=False) == []
