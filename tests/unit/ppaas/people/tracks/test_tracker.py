"""Tracker of a robot: ids are kept through gaps and crossings, false detections do not become people."""

from collections.abc import Iterable

import msgspec
import numpy as np
import pytest

from ppaas.people.tracks.tracker import Detection, LocalTrack, PeopleTracker, TrackerState

PERIOD = 0.1


def fed(tracker: PeopleTracker, frames: Iterable[list[tuple[float, float]]], start: int = 0) -> PeopleTracker:
    """Give a tracker one measurement every 0.1 s."""
    for number, frame in enumerate(frames, start):
        tracker.step(number * PERIOD, [Detection(x, y) for x, y in frame], expected=lambda _: False)
    return tracker


def walk(x: float, y: float, vx: float, vy: float, steps: range) -> list[tuple[float, float]]:
    return [(x + step * PERIOD * vx, y + step * PERIOD * vy) for step in steps]


def test_a_person_who_walks_keeps_the_id() -> None:
    tracker = fed(PeopleTracker(), ([at] for at in walk(0.0, 0.0, 1.2, 0.3, range(40))))
    [person] = tracker.people
    assert person.id == 1
    assert (person.vx, person.vy) == (pytest.approx(1.2, abs=0.1), pytest.approx(0.3, abs=0.1))


def test_the_id_is_kept_through_two_seconds_behind_a_column() -> None:
    tracker = fed(PeopleTracker(), ([at] for at in walk(0.0, 0.0, 1.0, 0.0, range(30))))
    fed(tracker, ([] for _ in range(20)), 30)
    fed(tracker, ([at] for at in walk(0.0, 0.0, 1.0, 0.0, range(50, 60))), 50)
    assert [person.id for person in tracker.people] == [1]


def test_two_who_cross_keep_their_ids() -> None:
    one, other = walk(0.0, 0.0, 1.0, 0.0, range(60)), walk(3.0, -3.0, 0.0, 1.0, range(60))
    tracker = fed(PeopleTracker(), (list(pair) for pair in zip(one, other, strict=True)))
    assert {person.id: round(person.vx) for person in tracker.people} == {1: 1, 2: 0}


def test_a_single_weak_detection_is_no_person() -> None:
    tracker = PeopleTracker()
    tracker.step(0.0, [Detection(1.0, 1.0, score=0.5)])
    assert tracker.people == []
    tracker.step(0.1, [])
    assert tracker.tracks == []


def test_weak_detections_that_last_are_a_person() -> None:
    tracker = PeopleTracker()
    for step in range(15):
        tracker.step(step * PERIOD, [Detection(1.0, 1.0, score=0.55)])
    assert [person.id for person in tracker.people] == [1]


def test_a_person_who_should_be_seen_and_is_not_has_left() -> None:
    tracker = fed(PeopleTracker(), ([(1.0, 1.0)] for _ in range(10)))
    for step in range(10, 18):
        tracker.step(step * PERIOD, [])
    assert tracker.tracks == []


def test_an_id_is_never_given_twice() -> None:
    tracker = fed(PeopleTracker(), ([(1.0, 1.0)] for _ in range(5)))
    tracker.step(100.0, [])
    tracker.step(100.1, [Detection(1.0, 1.0)])
    assert [person.id for person in tracker.people] == [2]


def test_a_measurement_before_the_last_is_taken_as_of_now() -> None:
    tracker = fed(PeopleTracker(), ([(1.0, 1.0)] for _ in range(5)))
    tracker.step(0.1, [Detection(1.0, 1.0)])
    assert tracker.at == pytest.approx(0.4)
    assert len(tracker.people) == 1


def test_whether_a_person_should_be_seen_is_asked_for_each_who_is_not() -> None:
    asked: list[int] = []

    def expected(track: LocalTrack) -> bool:
        asked.append(track.id)
        return False

    tracker = fed(PeopleTracker(), ([(1.0, 1.0), (4.0, 4.0)] for _ in range(5)))
    tracker.step(0.5, [Detection(1.0, 1.0)], expected)
    assert asked == [2]
    assert np.hypot(tracker.tracks[0].x - 1.0, tracker.tracks[0].y - 1.0) < 0.05


def test_ids_of_a_detector_decide_between_tracks_that_are_near_but_not_across_the_room():
    tracker = PeopleTracker()
    tracker.step(0.0, [Detection(0.0, 0.0), Detection(0.7, 0.0)])
    first, second = tracker.assigned
    tracker.step(0.1, [Detection(0.3, 0.0, believed=second), Detection(0.4, 0.0, believed=first)])
    assert tracker.assigned == [second, first]
    tracker.step(0.2, [Detection(5.0, 0.0, believed=first)])
    assert tracker.assigned[0] not in (0, first, second)


def test_detection_that_begins_no_track_is_assigned_to_none():
    tracker = PeopleTracker()
    tracker.step(0.0, [Detection(0.0, 0.0, begins=False)])
    assert tracker.assigned == [0]


def test_restored_tracker_goes_on_as_the_one_before():
    tracker, restored = PeopleTracker(), PeopleTracker()
    restored.restore(msgspec.json.decode(msgspec.json.encode(tracker.state()), type=TrackerState))
    assert restored.tracks == []
    for step in range(5):
        tracker.step(0.1 * step, [Detection(0.1 * step, 0.0), Detection(3.0, 1.0)])
    restored.restore(msgspec.json.decode(msgspec.json.encode(tracker.state()), type=TrackerState))
    for each in (tracker, restored):
        each.step(0.5, [Detection(0.5, 0.0), Detection(6.0, 1.0)])
    assert restored.tracks == tracker.tracks
    assert restored.assigned == tracker.assigned


def test_a_detection_of_a_person_in_sight_is_not_taken_for_a_hidden_one() -> None:
    tracker = fed(PeopleTracker(), ([(0.0, 0.0), (0.6, 0.0)] for _ in range(10)))
    fed(tracker, ([(0.0, 0.0)] for _ in range(12)), 10)  # the other is hidden, and may be anywhere around by now
    tracker.step(2.2, [Detection(0.1, 0.0)], expected=lambda _: False)
    assert tracker.assigned == [1]


def test_two_tracks_in_one_place_that_are_never_detected_at_once_become_one() -> None:
    tracker = PeopleTracker()
    tracker.step(0.0, [Detection(0.0, 0.0), Detection(0.35, 0.0)])
    for step in range(1, 15):  # each detection is of the track that the other was not
        tracker.step(step * PERIOD, [Detection(0.17 + 0.01 * (-1) ** step, 0.0)], expected=lambda _: False)
    fed(tracker, ([(0.17, 0.0)] for _ in range(15)), 15)
    assert [person.id for person in tracker.people] == [1]


def test_two_people_close_to_each_other_who_are_both_detected_stay_two() -> None:
    tracker = fed(PeopleTracker(), ([(0.0, 0.0), (0.35, 0.0)] for _ in range(30)))
    assert {person.id for person in tracker.people} == {1, 2}
