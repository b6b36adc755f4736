"""Tracker of the people that one robot sees: views, tracks, Torso IDs."""

import math
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from ppaas.people.tracks.robot_tracker import (
    HELD,
    MOST,
    RobotTracker,
    RobotTrackerState,
    TorsoIds,
    hides,
    sees,
)
from ppaas.people.tracks.tracker import Detection, LocalTrack

ROBOT = Pose2D(0.0, 0.0)
VIEW = SensorView(0.0, 0.0, 0.0, 1.5, 0.3, 6.0)
TORSO, LEGS = "torso", "legs"


def found(x: float, y: float = 0.0, **fields: object) -> Detection:
    return replace(Detection(x, y, (0.01, 0.0, 0.01), 0.95, z=1.2), **fields)


def walk(tracker: RobotTracker, steps: int, speed: float = 1.0, source: str = TORSO) -> None:
    """Let a person walk ahead of the robot, from 1 m."""
    for step in range(steps):
        tracker.step(source, 0.1 * step, [found(1.0 + 0.1 * step * speed)], VIEW, ROBOT)


def by_id(tracker: RobotTracker) -> dict[int, LocalTrack]:
    return {person.id: person for person in tracker.seen()}


def test_position_is_that_of_the_detection_itself_and_predicted_without_one():
    tracker = RobotTracker()
    walk(tracker, 20)
    [person] = tracker.seen()
    assert (person.x, person.y, person.z) == (pytest.approx(2.9), 0.0, 1.2)
    assert person.covariance == (0.01, 0.0, 0.01)
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
    other.step(LEGS, 1.0, [found(2.0, z=0.0)], VIEW, ROBOT)
    assert list(by_id(other)) == [1]
    assert by_id(other)[1].z == 1.2


@given(
    st.lists(st.sets(st.integers(1, 400), max_size=30), max_size=20),
    st.sets(st.sampled_from(["12", "torso_1", "torso_2"])),
)
def test_tracks_have_different_ids_that_they_keep(steps, taken):
    ids: TorsoIds = TorsoIds()
    before: dict[int, str] = {}
    for tracks in steps:
        ids.keep(tracks)
        names = {track: ids.of(track, taken=taken) for track in sorted(tracks)}
        assert len(set(names.values())) == len(names)
        assert taken.isdisjoint(names.values())
        assert all(before.get(track, name) == name for track, name in names.items())
        before = names


def test_id_is_not_used_again_at_once():
    ids, names = TorsoIds(), []
    for track in range(MOST + 1):
        names.append(ids.of(track))
        ids.keep(())
    assert len(set(names[:MOST])) == MOST
    assert names[MOST] == names[0] == "torso_1"


def test_more_tracks_than_ids_have_ids_too():
    ids = TorsoIds()
    assert len({ids.of(track) for track in range(MOST + 50)}) == MOST + 50


def test_id_that_the_robot_gave_is_taken_unless_another_track_has_it():
    ids = TorsoIds()
    assert [ids.of(1, "17"), ids.of(2, "17"), ids.of(1, "18")] == ["17", "torso_1", "17"]


def test_restored_ids_go_on():
    ids, other = TorsoIds(), TorsoIds()
    ids.of(4)
    other.restore(ids.state())
    assert [other.of(4), other.of(5)] == ["torso_1", "torso_2"]


VIEWER = Pose2D(1.0, 1.0, math.pi / 2.0)
AHEAD = SensorView(0.5, 0.0, 0.0, 1.0, 0.5, 5.0)
AROUND = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.2, 5.0)


@pytest.mark.parametrize(
    ("place", "seen"),
    [((1.0, 3.0), True), ((1.0, 1.8), False), ((1.0, 6.8), False), ((2.5, 3.0), False), ((1.0, -1.0), False)],
)
def test_point_is_in_the_view_of_a_camera_by_range_and_bearing(place, seen):
    assert sees(AHEAD, VIEWER, *place) is seen


def test_laser_sees_behind_the_robot():
    assert sees(AROUND, VIEWER, 1.0, -1.0)


def test_person_before_another_hides_them():
    assert hides(AHEAD, VIEWER, (1.0, 3.0), 1.1, 5.0)
    assert not hides(AHEAD, VIEWER, (1.1, 5.0), 1.0, 3.0)
    assert not hides(AHEAD, VIEWER, (1.0, 3.0), 2.5, 5.0)
