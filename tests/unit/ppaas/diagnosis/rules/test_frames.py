"""Rules on frames and stamps."""

import pytest

from ppaas.diagnosis.observations.facts import FrameFacts, MotionFacts, Observations, ScanFacts
from ppaas.diagnosis.rules.frames import frames, stamps
from tests.support.world.diagnosed_robot import healthy, with_topic

TREE = {"odom": "map", "base_link": "odom", "base_scan": "base_link"}


def seen_with(tree: dict[str, str], laser: str = "base_scan", **changed: object) -> Observations:
    """Return observations with a tree of frames, parents by children."""
    known = [FrameFacts(name=child, parents=(parent,)) for child, parent in tree.items()]
    return healthy(frames=known, scans=[ScanFacts(frame=laser, beams=360, readings=1.0)], **changed)


def test_complete_tree_has_no_finding() -> None:
    motion = MotionFacts(parent="odom", child="base_link")
    assert list(frames(seen_with(TREE, motion=motion))) == []


def test_scan_without_a_frame_is_at_the_centre_of_the_robot() -> None:
    assert list(frames(seen_with(TREE, laser=""))) == []


def test_unknown_frame_of_the_laser_is_named_with_the_known_ones_and_the_nearest() -> None:
    [finding] = frames(seen_with(TREE, laser="base_scn"))
    assert (finding.kind, finding.level) == ("frames-laser-unknown", "error")
    assert "'base_scn', has no transform to 'base_link'" in finding.text
    assert "base_link, base_scan, map, odom" in finding.advice
    assert "Did you mean 'base_scan'?" in finding.advice


def test_frame_with_another_prefix_is_recognised() -> None:
    [finding] = frames(seen_with({"robot1/base_scan": "base_link"}, laser="base_scan"))
    assert "Did you mean 'robot1/base_scan'?" in finding.advice


def test_frame_with_the_prefix_of_the_robot_is_known() -> None:
    assert list(frames(seen_with({"r1/laser": "base_link"}, laser="laser", prefix="r1"))) == []


def test_laser_in_another_tree_is_not_connected() -> None:
    [finding] = frames(seen_with({**TREE, "laser": "tower"}, laser="laser"))
    assert finding.kind == "frames-laser-apart"
    assert "'base_link' → 'tower'" in finding.advice


def test_loop_is_named_frame_by_frame() -> None:
    found = list(frames(seen_with({"base_link": "base_scan", "base_scan": "base_link"})))
    assert "base_link → base_scan → base_link" in found[0].text
    assert found[0].kind == "frames-loop"


def test_two_parents_and_two_senders_of_a_frame_are_found() -> None:
    known = [
        FrameFacts(name="base_link", parents=("odom", "odom_combined")),
        FrameFacts(name="odom", parents=("map",), alternates=True),
    ]
    assert [finding.kind for finding in frames(healthy(frames=known))] == ["frames-two-parents", "frames-two-senders"]


@pytest.mark.parametrize(
    ("parent", "child", "kind"),
    [
        ("odom", "camera_pose_frame", "frames-odom-child"),
        ("base_link", "base_link", "frames-odom-parent"),
        ("map", "base_link", "frames-odom-parent"),
    ],
)
def test_frames_of_the_odometry_are_checked(parent: str, child: str, kind: str) -> None:
    [finding] = frames(seen_with(TREE, motion=MotionFacts(parent=parent, child=child)))
    assert (finding.kind, finding.topic) == (kind, "odom")


def test_stamps_of_a_healthy_robot_are_in_order() -> None:
    assert list(stamps(healthy())) == []


@pytest.mark.parametrize(("late", "word"), [(40.0, "40.0 s behind"), (-3600.0 * 5, "5 h ahead of")])
def test_clock_that_differs_is_told_with_its_size_and_side(late: float, word: str) -> None:
    seen = healthy()
    seen.topics = [with_topic("scan", late=late).topic("scan"), with_topic("odom", late=late).topic("odom")]
    [finding] = stamps(seen)
    assert (finding.kind, finding.level) == ("clock-skew", "warn")
    assert f"The robot's clock is {word} the cloud's" in finding.text
    assert "NTP" in finding.advice


def test_stamps_since_the_start_of_a_simulation_are_no_skew_of_decades() -> None:
    seen = healthy(topics=[with_topic("odom", late=1.7e9).topic("odom")])
    assert [finding.kind for finding in stamps(seen)] == ["stamps-not-epoch"]


@pytest.mark.parametrize(("late", "level"), [(0.5, "warn"), (3.0, "error"), (-3.0, "error")])
def test_scans_by_another_clock_than_odometry_are_found(late: float, level: str) -> None:
    [finding] = stamps(with_topic("scan", late=late))
    assert (finding.kind, finding.level) == ("scan-odom-clocks", level)
    assert ("before" if late > 0 else "ahead of") in finding.text


@pytest.mark.parametrize(
    ("changed", "kind", "level"),
    [
        ({"unstamped": 1.0}, "stamps-zero", "ok"),
        ({"unstamped": 0.3}, "stamps-mixed", "warn"),
        ({"backwards": 3}, "stamps-backwards", "warn"),
    ],
)
def test_stamps_that_are_zero_or_run_backwards_are_found(changed: dict[str, float], kind: str, level: str) -> None:
    [finding] = stamps(with_topic("odom", **changed))
    assert (finding.kind, finding.level, finding.topic) == (kind, level, "odom")
