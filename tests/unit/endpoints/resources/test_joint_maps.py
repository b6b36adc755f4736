"""Choice of the maps that are joined next, and what is told of it."""

from hypothesis import given
from hypothesis import strategies as st

from endpoints.resources.joint_maps import (
    ALONE,
    EXCHANGE,
    EXCHANGE_PERIOD,
    LEAST,
    MERGE_PERIOD,
    MOST_ROBOTS,
    SILENT_PERIOD,
    JoinSchedule,
    RobotMap,
    Sharing,
)
from ppaas.clock import ManualClock

OFFICE = "new:office@ann"


def robot(name, frame, key_frames=LEAST, scans=100, user="ann"):
    return RobotMap(user, name, frame, key_frames, scans)


def maps(*robots, name=OFFICE, clock=None):
    clock = clock or ManualClock(1000.0)
    joint = JoinSchedule(clock, clock)
    joint.report({name: robots})
    return joint


def frames(join):
    return [group[0].frame for group in join.groups]


def test_maps_of_one_name_are_joined_in_the_frame_of_the_older_one():
    join = maps(robot("tb1", "a", scans=100), robot("tb2", "b", scans=300)).next_join()
    assert frames(join) == ["b", "a"]
    assert (join.joint_map, join.owner) == (OFFICE, "ann")


def test_maps_of_other_names_are_not_joined():
    joint = JoinSchedule()
    joint.report({OFFICE: [robot("tb1", "a")], "new:attic@ann": [robot("tb2", "b")]})
    assert joint.next_join() is None


def test_small_maps_wait():
    assert maps(robot("tb1", "a", LEAST - 1), robot("tb2", "b", 900)).next_join() is None
    assert maps(robot("tb1", "a"), robot("tb2", "b")).next_join() is not None


def test_refused_maps_are_tried_again_when_they_have_grown_and_some_time_has_passed():
    clock = ManualClock(1000.0)
    joint = maps(robot("tb1", "a", 100), robot("tb2", "b", 100), clock=clock)
    joint.done(joint.next_join(), 200, "too few places")
    grown = {OFFICE: [robot("tb1", "a", 150), robot("tb2", "b", 100)]}
    joint.report(grown)
    assert joint.next_join() is None
    clock.advance(MERGE_PERIOD)
    assert joint.next_join() is not None
    joint.done(joint.next_join(), 250, "too few places")
    clock.advance(10.0 * MERGE_PERIOD)
    assert joint.next_join() is None
    assert joint.sharing("ann", "tb2") == Sharing((), "too few places", 1000.0 + MERGE_PERIOD)


def test_robots_that_did_not_answer_are_tried_again_without_growing():
    clock = ManualClock(1000.0)
    joint = maps(robot("tb1", "a"), robot("tb2", "b"), clock=clock)
    joint.done(joint.next_join(), 0, "robot 'tb2' has no container now")
    clock.advance(MERGE_PERIOD)
    assert joint.next_join() is None
    clock.advance(SILENT_PERIOD)
    assert joint.next_join() is not None


def test_robots_in_one_frame_exchange_what_they_mapped():
    clock = ManualClock(1000.0)
    joint = maps(robot("tb1", "a", scans=200), robot("tb2", "b"), clock=clock)
    joint.done(joint.next_join(), 80)
    both = [robot("tb1", "a", 40), robot("tb2", "a", 40, user="bob")]
    joint.report({OFFICE: both})
    clock.advance(EXCHANGE_PERIOD)
    assert joint.next_join() is None
    assert joint.sharing("ann", "tb1") == Sharing(("bob/tb2",), "", 1000.0)
    assert joint.sharing("bob", "tb2").joined_with == ("ann/tb1",)
    joint.report({OFFICE: [robot("tb1", "a", 40 + EXCHANGE), both[1]]})
    join = joint.next_join()
    assert frames(join) == ["a"]
    assert len(join.robots) == 2


def test_frames_found_joined_after_a_restart_are_exchanged_once():
    joint = maps(robot("tb1", "a", 40), robot("tb2", "a", 40))
    joint.done(joint.next_join(), 80)
    assert joint.next_join() is None


def test_group_and_a_robot_are_joined_as_two_groups():
    joint = maps(robot("tb1", "a", 40), robot("tb2", "a", 40), robot("tb3", "b", 40, scans=900))
    joint.done(joint.next_join(), 80)
    join = joint.next_join()
    assert frames(join) == ["b", "a"]
    assert [one.robot for one in join.robots] == ["tb3", "tb1", "tb2"]


def test_joint_maps_have_a_largest_number_of_robots():
    crowd = [robot(f"tb{k}", "a", 40) for k in range(MOST_ROBOTS)]
    joint = maps(*crowd, robot("more", "b", 40))
    joint.done(joint.next_join(), 40 * MOST_ROBOTS)
    assert joint.next_join() is None


def test_users_take_turns():
    clock = ManualClock(1000.0)
    joint = JoinSchedule(clock, clock)
    crowd = {
        f"new:office@{owner}": [robot(f"tb{k}", f"{owner}{k}", user=owner) for k in range(count)]
        for owner, count in (("ann", 4), ("bob", 2))
    }
    joint.report(crowd)
    served = []
    for _ in range(3):
        join = joint.next_join()
        served.append(join.owner)
        clock.advance(1.0)
        joint.done(join, 1000, "too few places")
    assert sorted(served[:2]) == ["ann", "bob"]
    assert served[2] == "ann"


def test_robots_that_left_are_forgotten():
    joint = maps(robot("tb1", "a"), robot("tb2", "b"))
    joint.done(joint.next_join(), 40, "too few places")
    joint.report({})
    assert joint.sharing("ann", "tb1") == ALONE
    joint.report({OFFICE: [robot("tb1", "a"), robot("tb2", "b")]})
    assert joint.next_join() is not None


@given(sizes=st.lists(st.integers(1, 40), min_size=1, max_size=60))
def test_attempts_are_few_however_often_is_looked(sizes):
    clock = ManualClock(0.0)
    joint = JoinSchedule(clock, clock)
    size = attempts = 0
    for more in sizes:
        clock.advance(100.0)
        size += more
        joint.report({OFFICE: [robot("tb1", "a", size), robot("tb2", "b", size)]})
        if (join := joint.next_join()) is not None:
            attempts += 1
            joint.done(join, 2 * size, "too few places")
    assert attempts <= 14 + 2 * len(sizes) / 10 + size / 60
