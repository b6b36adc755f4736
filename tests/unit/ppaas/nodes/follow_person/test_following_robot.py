"""Node ``follow_person`` in a whole clone: a simulated robot follows a person who walks."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.people_coordination import FOLLOWING, PAUSED, SEARCHING, WAITING
from ppaas.people.following.places import Places
from ppaas.people.talking_groups import distances_to
from tests.support.world.following_loop import FollowingLoop, Walker, along
from tests.support.world.planar_world import walled_map

HALL = walled_map(11, 6, [])
ROOMS = walled_map(10, 8, [(0, 3.9, 4, 4.1), (5, 3.9, 10, 4.1)])
START = Pose2D(1.0, 3.0)


def test_robot_follows_around_corners_at_the_speed_of_the_person_without_a_stop():
    way = along((2.5, 3.0), (6.0, 3.0), (6.0, 5.0), (4.5, 5.0), speed=0.45, begin=2.0)
    loop = FollowingLoop(HALL, START, [Walker(1, way)])
    loop.follow(5.0)
    began = len(loop.trace)
    loop.follow(11.0)
    speeds = [speed for _, _, speed in loop.trace[began:]]
    assert min(speeds) > 0.1 and np.mean(speeds) == pytest.approx(0.45, abs=0.08)
    assert min(loop.distances[began:]) > 0.8 and max(loop.distances[began:]) < 1.7
    loop.follow(5.0)
    assert loop.states[-2:] == [FOLLOWING, WAITING] and loop.command.linear.x == 0.0
    assert loop.distances[-1] == pytest.approx(1.1, abs=0.35)


def test_robot_stands_while_the_person_comes_and_follows_when_past():
    loop = FollowingLoop(HALL, START, [Walker(1, along((7.0, 3.9), (1.0, 3.9), speed=0.7, begin=2.5))])
    loop.follow(11.5)
    coming = [speed for robot, person, speed in loop.trace if robot.x + 0.5 < person[0] < robot.x + 2.0]
    assert len(coming) > 30 and max(coming) == 0.0
    assert min(loop.distances) > 0.6
    loop.follow(4.0)
    assert loop.distances[-1] < 1.9


def test_robot_never_drives_between_two_who_talk():
    talking = [Walker(1, along((6.0, 3.8)), group=1), Walker(2, along((6.0, 2.2)), group=1)]
    loop = FollowingLoop(HALL, Pose2D(9.5, 2.9), talking, distance=1.2)
    loop.follow(9.0)
    members = np.array([[6.0, 3.8], [6.0, 2.2]])
    poses = np.array([pose[:2] for pose, *_ in loop.trace])
    assert distances_to(poses, [members]).min() > 0.5
    assert loop.states[-1] == WAITING and loop.distances[-1] < 1.7


def test_robot_finds_a_person_who_vanished_through_a_door():
    way = along((2.5, 2.0), (4.5, 2.0), (4.5, 6.0), (7.0, 6.0), speed=0.6, begin=1.5)
    loop = FollowingLoop(ROOMS, Pose2D(1.0, 2.0), [Walker(1, way)])
    places = Places(loop.layers)

    def in_view(now: float) -> bool:
        pose, person = loop.world.pose, way(now)
        off = math.atan2(person[1] - pose.y, person[0] - pose.x) - pose.theta
        apart = math.dist(person, pose[:2])
        return (now < 4.5 or now > 10.0) and math.cos(off) > 0.88 and apart < 5.0 and places.sees(pose[:2], person)

    loop.people[0].seen = in_view
    for _ in range(60):
        loop.follow(0.5)
        if loop.states[-2:] == [FOLLOWING, WAITING] and SEARCHING in loop.states:
            break
    assert SEARCHING in loop.states and loop.states[-1] == WAITING
    assert loop.now < 28.0 and loop.distances[-1] < 1.7


def test_goal_of_an_operator_is_reached_before_following_goes_on():
    loop = FollowingLoop(HALL, START, [Walker(1, along((5.0, 3.0)))])
    loop.follow(3.0)
    goal = Pose2D(2.0, 1.5, 0.0)
    loop.send_goal(goal)
    loop.run(1.0)
    assert loop.last_status() is Status.PREEMPTED, "that of the node"
    loop.run(10.0)
    assert loop.last_status() is Status.SUCCEEDED and loop.world.pose.distance_to(goal) < 0.2
    assert loop.status.state == PAUSED and not loop.status.can_follow
    loop.follow(9.0)
    assert loop.distances[-1] < 1.7
