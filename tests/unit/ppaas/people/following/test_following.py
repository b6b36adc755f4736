"""Following of a person: progress, the person's path, and what the robot does."""

import math

import msgspec
import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import (
    FOLLOWING,
    GAVE_UP,
    LOST,
    PREDICTED,
    SEARCHING,
    SEEN,
    WAITING,
    GroupRobot,
    PeopleState,
    SensorView,
    TrackedPerson,
)
from ppaas.people.following.following import (
    AHEAD,
    FORGOTTEN,
    LONGEST_PREDICTION,
    STUCK,
    UNKNOWN,
    Following,
    Target,
    UnreachedPlaces,
)
from ppaas.people.following.parameters import FollowParameters
from ppaas.people.following.places import GROUP_MARGIN, Places
from ppaas.people.talking_groups import distances_to
from tests.support.world.planar_world import walled_map

HALL = Places(build_layers(walled_map(12, 6, [])))
VIEWS = [SensorView(0.0, 0.0, 0.0, 1.0, 0.0, 5.0)]
ROBOT = Pose2D(2.0, 3.0, 0.0)


def person(x: float, y: float = 3.0, vx: float = 0.0, vy: float = 0.0, *, number: int = 1, group: int = 0, state=SEEN):
    return TrackedPerson(number, Point(x, y), Point(vx, vy), [0.0] * 4, state=state, group=group)


def following(*people: TrackedPerson, now: float = 0.0, places: Places = HALL, **parameters) -> Following:
    found = Following(1, "r", FollowParameters(**parameters), places, now)
    hear(found, *people, now=now)
    return found


def hear(found: Following, *people: TrackedPerson, now: float = 0.0, robots=()) -> None:
    found.hear(PeopleState(Header(), len(people), list(people), robots=list(robots)), now)


def step(*people: TrackedPerson, robot: Pose2D = ROBOT, **parameters):
    return following(*people, **parameters).step(0.0, robot, VIEWS)


# -- distance, side and speed ------------------------------------------------------------------------------------------


def test_robot_drives_to_the_distance_from_a_person_who_stands_and_faces_the_person():
    done = step(person(6.0))
    assert done.state == FOLLOWING and done.distance == pytest.approx(4.0)
    assert done.place == pytest.approx((4.8, 3.0, 0.0))
    assert done.speed == 0.0


def test_robot_stays_near_a_person_who_stands():
    found = following(person(3.2))
    assert found.step(0.0, ROBOT, VIEWS).state == WAITING
    hear(found, person(3.5), now=0.5)
    assert found.step(0.5, ROBOT, VIEWS).state == WAITING
    hear(found, person(3.9), now=1.0)
    assert found.step(1.0, ROBOT, VIEWS).state == FOLLOWING


def test_robot_does_not_back_off_from_a_person_who_steps_near_but_turns_to_the_person():
    done = step(person(2.0, 3.7))
    assert done.state == WAITING
    assert done.place == pytest.approx((2.0, 3.0, math.pi / 2))


def test_goal_is_ahead_of_the_distance_behind_a_person_who_walks():
    done = step(person(3.2, vx=0.5))
    assert done.state == FOLLOWING
    assert done.place.x == pytest.approx(2.0 + AHEAD * 0.5, abs=0.05)


@pytest.mark.parametrize(("side", "beside"), [("left", 1), ("right", -1)])
def test_robot_drives_on_the_wanted_side_of_a_person_who_walks(side, beside):
    done = step(person(3.5, vx=0.4), side=side)
    assert beside * (done.place.y - 3.0) > 0.8


@pytest.mark.parametrize(("apart", "speed"), [(1.2, 0.5), (1.5, 0.74), (1.0, 0.34), (8.0, 0.0)])
def test_speed_is_that_of_the_person_and_corrects_the_distance(apart, speed):
    assert step(person(2.0 + apart, vx=0.5)).speed == pytest.approx(speed)


def test_speed_is_limited_by_the_parameter():
    assert step(person(3.5, vx=0.5), max_speed=0.3).speed == 0.3
    assert step(person(7.0), max_speed=0.3).speed == 0.3


# -- people in the way -------------------------------------------------------------------------------------------------


def test_robot_stands_while_the_person_comes_towards_it():
    done = step(person(4.5, vx=-0.6))
    assert (done.state, done.place) == (WAITING, None)
    assert done.reason == "the person comes towards the robot"
    assert step(person(4.5, vx=-0.6), robot=Pose2D(8.0, 3.0, math.pi)).state == FOLLOWING


def test_robot_drives_on_while_the_person_comes_from_afar_or_will_pass_far_beside_it():
    done = step(person(7.0, vx=-0.6))
    assert done.state == FOLLOWING
    assert done.place == pytest.approx((7.0 - 0.6 * AHEAD - 1.2, 3.0, 0.0)), "straight ahead, where it sees the person"
    assert step(person(4.5, 4.8, vx=-0.6)).state == FOLLOWING
    assert step(person(4.5, 3.8, vx=-0.6)).state == WAITING


def test_robot_stands_outside_of_the_space_between_two_who_talk():
    talking = person(6.0, 3.7, group=1), person(6.0, 2.3, group=1, number=2)
    members = np.array([[6.0, 3.7], [6.0, 2.3]])
    done = step(*talking, robot=Pose2D(6.0, 3.0))
    assert done.state == FOLLOWING, "it leaves the space although it is near enough"
    assert distances_to(np.array([done.place[:2]]), [members])[0] >= GROUP_MARGIN


def test_robot_keeps_clear_of_other_people_and_robots():
    found = following(person(6.0))
    others = person(4.8, number=2), person(4.6, number=3, state=LOST)
    hear(
        found,
        person(6.0),
        *others,
        robots=[GroupRobot("r", Point(4.8, 3.0), 0.1), GroupRobot("s", Point(6.0, 1.8), 0.1)],
    )
    place = found.step(0.0, ROBOT, VIEWS).place
    assert math.dist(place[:2], (4.8, 3.0)) >= 0.8
    assert math.dist(place[:2], (6.0, 1.8)) >= 0.6


# -- failures ----------------------------------------------------------------------------------------------------------


def test_place_that_is_not_reached_is_replaced_and_the_person_given_up_in_the_end():
    found = following(person(6.0))
    now, tried = 0.0, []
    while not found.gave_up and now < 200.0:
        now += 0.5
        hear(found, person(6.0), now=now)
        done = found.step(now, ROBOT, VIEWS)
        if done.place is not None and done.place not in tried:
            tried.append(done.place)
    assert len(tried) >= 3 and now < 8 * STUCK
    assert "cannot be reached" in found.gave_up
    assert found.step(now, ROBOT, VIEWS).state == GAVE_UP


def test_failures_of_move_base_count_too():
    found = following(person(6.0))
    for _ in range(4):
        assert not found.gave_up
        found.step(0.0, ROBOT, VIEWS)
        found.failed("Failed to find a valid plan.")
    assert found.gave_up == "person 1 cannot be reached: Failed to find a valid plan."


def test_person_whom_the_coordinator_does_not_know_is_given_up():
    found = following(person(6.0, number=2))
    assert found.step(1.0, ROBOT, VIEWS).state == WAITING
    assert found.step(UNKNOWN + 1.0, ROBOT, VIEWS).state == GAVE_UP


# -- hidden people -----------------------------------------------------------------------------------------------------


def vanished(seconds: float, **parameters) -> tuple[Following, list]:
    found = following(person(8.0, vx=0.5), **parameters)
    steps = []
    for number in range(round(seconds / 0.5)):
        now = 0.5 * number
        hear(found, person(8.0 + 0.5 * now, vx=0.5, state=PREDICTED if now < 5.0 else LOST), now=now + 0.01)
        steps.append(found.step(now + 0.01, ROBOT, VIEWS))
    return found, steps


def test_hidden_person_is_followed_to_the_prediction_and_then_searched():
    _, steps = vanished(6.0, hidden_patience=2.0)
    states = [each.state for each in steps]
    assert states == [FOLLOWING] * 4 + [SEARCHING] * 8
    assert steps[3].place.x > steps[0].place.x


def test_person_who_was_not_found_in_time_is_given_up_until_seen_again():
    found, steps = vanished(10.0, search_timeout=4.0)
    assert steps[-1].state == GAVE_UP
    assert steps[-1].reason == "person 1 was not found within 4 s"
    hear(found, person(6.0), now=10.1)
    assert found.step(10.2, ROBOT, VIEWS).state == FOLLOWING


def test_search_ends_where_everything_was_seen():
    closet = Places(build_layers(walled_map(2, 2, [])))
    found = following(person(1.5, 1.0), places=closet)
    all_around = [SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.0, 5.0)]
    done = found.step(5.0, Pose2D(0.8, 1.0), all_around)
    assert (done.state, done.reason) == (GAVE_UP, "person 1 is nowhere near the place of the last sight")


def test_search_begins_again_on_another_map():
    found, _ = vanished(4.0)
    found.use_places(HALL)
    hear(found, person(8.0, state=PREDICTED), now=4.5)
    assert found.step(4.6, ROBOT, VIEWS).state == SEARCHING


@pytest.mark.parametrize(
    ("x", "first_seen", "rule", "state"),
    [
        (8.2, 12, "nearest", GAVE_UP), (8.2, 12, "named", SEARCHING), (8.2, 3, "nearest", SEARCHING),
        (1.0, 12, "nearest", SEARCHING),
    ],
    ids=["appeared there", "another is named", "known before", "elsewhere"],
)  # fmt: skip
def test_search_ends_for_somebody_who_appears_where_the_person_may_be(x, first_seen, rule, state):
    lost = person(8.0, state=LOST)
    found = following(msgspec.structs.replace(person(8.0), first_seen=Time(2, 0), last_seen=Time(10, 0)))
    hear(found, lost, now=4.0)
    assert found.step(4.0, ROBOT, VIEWS).state == SEARCHING
    other = msgspec.structs.replace(person(x, number=9), first_seen=Time(first_seen, 0))
    found.hear(PeopleState(Header(), 1, [lost, other], rule=rule), 4.2)
    done = found.step(4.2, ROBOT, VIEWS)
    assert done.state == state
    if state == GAVE_UP:
        assert done.reason == "person 9 appeared where person 1 may be"


PLACE = Pose2D(5.0, 0.0)


def test_robot_that_stands_before_a_place_is_stuck_after_a_while_and_the_place_is_avoided_for_a_time():
    progress = UnreachedPlaces()
    assert not progress.is_stuck(0.0, Pose2D(0.0, 0.0), PLACE)
    assert not progress.is_stuck(STUCK, Pose2D(0.1, 0.0), PLACE)
    assert progress.is_stuck(STUCK + 0.5, Pose2D(0.1, 0.0), PLACE)
    assert progress.failed(STUCK + 1.0).tolist() == [[5.0, 0.0]] and progress.failures == 1
    assert not len(progress.failed(STUCK + 1.0 + FORGOTTEN))


def test_robot_that_moves_or_has_arrived_is_not_stuck():
    progress = UnreachedPlaces()
    for second in range(30):
        assert not progress.is_stuck(float(second), Pose2D(0.1 * second, 0.0), PLACE)
    arrived = UnreachedPlaces()
    assert not any(arrived.is_stuck(float(second), Pose2D(4.9, 0.0), PLACE) for second in range(30))


@pytest.mark.parametrize("pauses", [True, False])
def test_time_counts_anew_for_another_place_and_after_a_rest(pauses):
    progress, here = UnreachedPlaces(), Pose2D(0.0, 0.0)
    progress.is_stuck(0.0, here, PLACE)
    if pauses:
        progress.rest()
    other = PLACE if pauses else Pose2D(0.0, 5.0)
    assert not progress.is_stuck(STUCK + 1.0, here, other)
    assert not progress.is_stuck(2.0 * STUCK, here, other)


def test_failures_are_forgotten_where_the_robot_stands_well():
    progress = UnreachedPlaces()
    assert [progress.fail(0.0), progress.fail(0.0)] == [1, 2]
    progress.reset()
    assert progress.fail(0.0) == 1


def walker(x: float, y: float = 0.0, vx: float = 0.5, vy: float = 0.0, state: str = SEEN) -> TrackedPerson:
    return TrackedPerson(1, Point(x, y), Point(vx, vy), [0.0] * 4, state=state)


def test_position_is_predicted_from_the_arrival_for_a_limited_time():
    target = Target(0.0)
    target.take(walker(1.0), 10.0)
    assert target.position(11.0) == (1.5, 0.0)
    assert target.position(11.0, 1.0) == (2.0, 0.0)
    assert target.position(99.0) == (1.0 + 0.5 * LONGEST_PREDICTION, 0.0)


def test_person_who_stands_is_not_expected_ahead():
    target = Target(0.0)
    target.take(walker(1.0, vx=0.05), 10.0)
    assert not target.walking and target.position(10.0, 1.0) == (1.0, 0.0)
    assert target.heading is None


def test_walking_begins_and_ends_at_different_speeds():
    target = Target(0.0)
    walks = []
    for speed in (0.2, 0.35, 0.2, 0.1, 0.2):
        target.take(walker(1.0, vx=speed), 1.0)
        walks.append(target.walking)
    assert walks == [False, True, True, False, False]
    assert target.heading == 0.0


def test_lost_or_missing_person_keeps_the_last_position():
    target = Target(0.0)
    target.take(None, 1.0)
    assert not target.known
    target.take(walker(1.0), 2.0)
    target.take(walker(5.0, state=LOST), 3.0)
    target.take(None, 4.0)
    assert target.known and target.position(2.0) == (1.0, 0.0) and target.seen_at == 2.0


def test_predicted_person_was_last_seen_before():
    target = Target(0.0)
    target.take(walker(1.0), 2.0)
    target.take(walker(3.0, state=PREDICTED), 6.0)
    assert target.seen_at == 2.0 and target.seen.position.x == 1.0 and target.last.position.x == 3.0


def test_place_behind_is_on_the_path_walked_also_around_a_corner():
    target = Target(0.0)
    for step in range(11):
        target.take(walker(0.2 * step), float(step))
    for step in range(1, 6):
        target.take(walker(2.0, 0.2 * step, 0.0, 0.5), 10.0 + step)
    assert target.behind(15.0, 0.0, 2.0) == pytest.approx((1.0, 0.0))
    assert target.behind(15.0, 1.0, 1.0) == pytest.approx((2.0, 0.5))
    assert target.behind(15.0, 0.0, 9.0) is None
    assert target.heading == pytest.approx(math.pi / 2)
