"""Tracker of one robot: several detectors, late detections, and people behind others."""

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.people.tracks.robot_tracker import HELD, Found, RobotTracker, RobotTrackerState, SeenPerson

ROBOT = Pose2D(0.0, 0.0)
VIEW = SensorView(0.0, 0.0, 0.0, 1.5, 0.3, 6.0)
TORSO, LEGS = "torso", "legs"


def found(x: float, y: float = 0.0, **fields: object) -> Found:
    return Found(x, y, 1.2, (0.01, 0.0, 0.01), 0.95, True)._replace(**fields)


def walk(tracker: RobotTracker, steps: int, speed: float = 1.0, source: str = TORSO) -> None:
    """Let a person walk ahead of the robot, from 1 m."""
    for step in range(steps):
        tracker.step(source, 0.1 * step, [found(1.0 + 0.1 * step * speed)], VIEW, ROBOT)


def by_id(tracker: RobotTracker) -> dict[int, SeenPerson]:
    return {person.id: person for person in tracker.seen()}


def test_position_is_that_of_the_detection_itself_and_predicted_without_one():
    tracker = RobotTracker()
    walk(tracker, 20)
    assert tracker.seen()[0][1:5] == (pytest.approx(2.9), 0.0, 1.2, (0.01, 0.0, 0.01))
    tracker.step(TORSO, 2.1, [], None, ROBOT)
    [person] = tracker.seen()
    assert person.x == pytest.approx(3.1, abs=0.05)
    assert person.covariance[0] > 0.0


def test_person_counts_as_seen_for_a_moment_after_the_last_detection():
    tracker = RobotTracker()
    walk(tracker, 5)
    tracker.predict(0.4 + HELD - 0.01)
    assert len(tracker.seen()) == 1
    tracker.predict(0.4 + HELD + 0.01)
    assert tracker.seen() == []


def test_late_detection_is_moved_on_with_the_person():
    tracker = RobotTracker()
    walk(tracker, 20, 1.5)
    tracker.step(LEGS, 1.7, [found(1.0 + 1.5 * 1.7, z=0.0)], VIEW, ROBOT)
    [person] = tracker.seen()
    assert person.x == pytest.approx(1.0 + 1.5 * 1.9, abs=0.05)
    assert person.z == 1.2, "lasers do not measure it"


def test_person_whom_one_detector_misses_stays_as_long_as_another_sees_them():
    tracker = RobotTracker()
    walk(tracker, 3)
    for step in range(40):
        tracker.step(LEGS, 0.3 + 0.1 * step, [], VIEW, ROBOT)
        if step % 2 == 0:
            tracker.step(TORSO, 0.3 + 0.1 * step, [found(1.3)], VIEW, ROBOT)
    assert list(by_id(tracker)) == [1]


def test_person_who_left_the_view_of_the_only_detector_is_forgotten_sooner_than_one_who_is_hidden():
    seen, hidden = RobotTracker(), RobotTracker()
    for tracker, other in ((seen, found(2.0, 1.0)), (hidden, found(1.2, 0.05))):
        for step in range(5):
            tracker.step(TORSO, 0.1 * step, [found(3.0), other], VIEW, ROBOT)
        for step in range(5, 18):
            tracker.step(TORSO, 0.1 * step, [other], VIEW, ROBOT)
    assert len(seen.tracks()) == 1
    assert len(hidden.tracks()) == 2


def test_all_people_are_forgotten_when_the_clock_is_set_back():
    tracker = RobotTracker()
    walk(tracker, 20)
    tracker.step(TORSO, -50.0, [found(2.0)], VIEW, ROBOT)
    assert tracker.at == -50.0
    assert list(by_id(tracker)) == [2]


def test_ids_of_a_detector_keep_crossing_people_apart():
    tracker = RobotTracker()
    for step in range(30):
        y = 0.6 - 0.04 * step
        people = [found(2.0, y, id="a"), found(2.1, -y, id="b")]
        tracker.step(TORSO, 0.1 * step, people if step % 2 else people[::-1], VIEW, ROBOT)
    first = {name: next(track for track in (1, 2) if tracker.name_by(TORSO, track) == name) for name in "ab"}
    assert by_id(tracker)[first["a"]].y == pytest.approx(-0.56)
    assert by_id(tracker)[first["b"]].y == pytest.approx(0.56)


def test_restored_tracker_goes_on_with_the_same_people():
    tracker, other = RobotTracker(), RobotTracker()
    walk(tracker, 10)
    other.restore(msgspec.json.decode(msgspec.json.encode(tracker.state()), type=RobotTrackerState))
    other.step(TORSO, 1.0, [found(2.0)], VIEW, ROBOT)
    assert list(by_id(other)) == [1]
