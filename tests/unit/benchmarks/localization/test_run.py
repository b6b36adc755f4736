"""Conditions under which a robot counts as found, and its route."""

import numpy as np
import pytest

from benchmarks.localization.crowd import CREEP, FARTHEST, NEAREST, TURN, Crowd, CrowdedWorld, Inching
from benchmarks.localization.route import RandomRoute
from benchmarks.localization.run import found_after
from ppaas.maps.generate import office
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

DISTANCES = np.arange(0.0, 10.0, 0.5)


@pytest.mark.parametrize(
    ("wrong", "found"),
    [([], 0.0), ([0.0], 0.5), ([0.0, 4.0], 4.5), ([7.0], 7.5), ([8.0], None), ([9.5], None)],
)
def test_a_robot_is_found_once_it_is_never_lost_again(wrong: list[float], found: float | None) -> None:
    assert found_after(DISTANCES, ~np.isin(DISTANCES, wrong)) == found


def test_a_robot_follows_its_route_from_goal_to_goal() -> None:
    grid = office(seed=1, width=12.0, height=10.0)
    route = RandomRoute(grid, np.random.default_rng(3))
    start = route.anywhere()
    route.begin(start)
    world = World(grid, 1)
    robot = world.add_robot(start)
    while robot.base.travelled < 25.0 and world.time() < 120.0:
        robot.command(route.steer(robot.base.pose))
        for _ in range(5):
            world.step()
    assert robot.base.travelled >= 25.0


GRID = office(seed=1, width=12.0, height=10.0)


def crowded(people: int, seed: int = 1) -> tuple[CrowdedWorld, SimulatedRobot, Crowd]:
    world, rng = CrowdedWorld(GRID, seed), np.random.default_rng(seed)
    robot = world.add_robot(RandomRoute(GRID, rng).anywhere())
    world.crowd = Crowd(robot, ShortestPaths(GRID, world.pedestrian_model.clearance, rng), people, rng)
    return world, robot, world.crowd


def test_people_stay_close_to_the_robot_and_move_about() -> None:
    world, robot, crowd = crowded(people=10)
    before = crowd.places
    for _ in range(500):
        world.step()
        distance = np.hypot(*(crowd.places - robot.base.pose[:2]).T)
        assert (distance > NEAREST - 1e-6).all()
        assert (distance < FARTHEST + 1e-6).all()
    assert (np.hypot(*(crowd.places - before).T) > 0.3).mean() > 0.5


def test_the_laser_detects_people_while_they_are_there() -> None:
    world, robot, _ = crowded(people=10)
    near = [sum(seen is not None and seen < FARTHEST for seen in robot.scan().ranges)]
    world.crowd = None
    near.append(sum(seen is not None and seen < FARTHEST for seen in robot.scan().ranges))
    assert near[0] > near[1] + 120


def test_a_robot_among_people_creeps_or_turns_in_place() -> None:
    world, rng = CrowdedWorld(GRID, 1), np.random.default_rng(1)
    route = RandomRoute(GRID, rng)
    start = route.anywhere()
    route.begin(start)
    robot, inching = world.add_robot(start), Inching(route, world, rng)
    turning = []
    while world.time() < 60.0:
        twist = inching.steer(robot.base.pose)
        robot.command(twist)
        turning.append(0.0 if twist.linear.x else round(twist.angular.z, 6))
        for _ in range(5):
            world.step()
    assert {-TURN, 0.0, TURN} <= set(turning)
    assert 0.5 < robot.base.travelled < 60.0 * CREEP
