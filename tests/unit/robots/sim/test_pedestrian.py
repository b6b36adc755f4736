"""Pedestrians walk to random destinations and avoid only what is ahead."""

import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.pedestrian import Pedestrian
from robots.sim.shortest_paths import PathWalk, ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room


class Towards(ShortestPaths):
    """Paths that all lead to one place."""

    goal = Pose2D(9.0, 2.0)

    def anywhere(self) -> Pose2D:
        return self.goal


def crowd(world: World, count: int) -> list[Pedestrian]:
    ways = ShortestPaths(world.grid, world.pedestrian_model.clearance, np.random.default_rng(4))
    return [world.add_pedestrian(ways, ways.anywhere()) for _ in range(count)]


def test_people_walk_at_own_speeds_without_contact() -> None:
    world = World(office(seed=1, width=12.0, height=10.0), 2)
    pedestrians = crowd(world, 4)
    ways, fastest, nearest = np.zeros(4), np.zeros(4), math.inf
    free = ShortestPaths(world.grid, 0.2, np.random.default_rng(1))
    for _ in range(1500):
        before = world.people()
        world.step()
        after = world.people()
        steps = np.hypot(*(after - before).T)
        ways, fastest = ways + steps, np.maximum(fastest, steps / world.dt)
        apart = np.hypot(*(after[:, None] - after[None]).transpose(2, 0, 1))
        nearest = min(nearest, float(apart[~np.eye(4, dtype=bool)].min()))
        assert all(free.allows(x, y) for x, y in after.tolist())
    assert (ways > 5.0).all()
    assert len(pedestrians) == len(set(np.round(fastest, 2)))
    assert (fastest <= world.pedestrian_model.fastest + 1e-6).all()
    assert nearest > 2.0 * world.pedestrian_model.radius


def test_the_same_seed_makes_the_same_walks() -> None:
    ends = []
    for _ in range(2):
        world = World(office(seed=1, width=12.0, height=10.0), 5)
        crowd(world, 2)
        for _ in range(200):
            world.step()
        ends.append(world.people())
    assert (ends[0] == ends[1]).all()


@pytest.mark.parametrize("aside", [0.0, 0.5])
def test_people_step_around_a_standing_robot(aside: float) -> None:
    world = World(room(10.0, 4.0), 3)
    robot = world.add_robot(Pose2D(5.0, 2.0 + aside))
    pedestrian = world.add_pedestrian(Towards(world.grid, 0.35, np.random.default_rng(1)), Pose2D(2.0, 2.0))
    nearest = math.inf
    for _ in range(1000):
        world.step()
        nearest = min(nearest, math.dist(pedestrian.body.position, robot.base.body.position))
    assert nearest > world.pedestrian_model.radius + robot.model.base.radius + 0.05
    assert pedestrian.body.position.x > 6.0


def test_people_stop_before_a_robot_in_a_corridor_and_turn_back() -> None:
    grid = room(10.0, 1.2)
    world = World(grid, 3)
    robot = world.add_robot(Pose2D(5.0, 0.6))
    ways = ShortestPaths(grid, 0.35, np.random.default_rng(1))
    pedestrian = world.add_pedestrian(ways, Pose2D(2.0, 0.6))
    for _ in range(2000):
        world.step()
        assert math.dist(pedestrian.body.position, robot.base.body.position) > 0.6
    assert pedestrian.body.position.x < 5.0


def test_a_blocked_pedestrian_chooses_another_destination() -> None:
    """The corridor is wide enough to step aside, but not to pass."""
    grid = room(10.0, 1.8)
    world = World(grid, 3)
    robot = world.add_robot(Pose2D(5.0, 0.9))
    pedestrian = world.add_pedestrian(ShortestPaths(grid, 0.35, np.random.default_rng(1)), Pose2D(2.0, 0.9))
    before, longest = 0.0, 0.0
    for _ in range(3000):
        world.step()
        before = before + world.dt if math.dist(pedestrian.body.position, robot.base.body.position) < 1.3 else 0.0
        longest = max(longest, before)
    assert longest < 50.0, "it gave up within the minute"


def test_driving_into_a_person_is_not_a_wall_contact() -> None:
    world = World(room(10.0, 4.0), 3)
    robot = world.add_robot(Pose2D(8.4, 2.0))
    world.add_pedestrian(Towards(world.grid, 0.35, np.random.default_rng(1)), Towards.goal)
    for _ in range(50):
        robot.command(Twist(Vector3(x=0.6)))
        world.step()
    assert world.contacts.person_contacts[0] == 1
    assert world.contacts.wall_contacts[0] == 0
    assert world.contacts.total(0) == 1


def test_the_laser_detects_people() -> None:
    world = World(room(10.0, 4.0), 3)
    robot = world.add_robot(Pose2D(5.0, 2.0))
    world.add_pedestrian(Towards(world.grid, 0.35, np.random.default_rng(1)), Pose2D(7.0, 2.0))
    ahead = robot.scan().ranges[robot.model.laser.beams // 2]
    assert ahead == pytest.approx(2.0 - world.pedestrian_model.radius, abs=0.05)


def test_a_path_that_returns_near_the_walker_is_not_cut_short() -> None:
    out = [(0.1 * step, 0.0) for step in range(30)]
    back = [(3.0 - 0.1 * step, 0.3) for step in range(30)]
    way = PathWalk(np.array(out + back))
    assert way.ahead(1.5, 0.0, 0.5) == (0.0, 0.0), "a walker far from its path returns to where it left it"
    for step in range(10):
        x, y = way.ahead(0.1 * step, 0.0, 0.5)
        assert (x, y) == (pytest.approx(0.1 * step + 0.4, abs=0.11), 0.0)
    assert not way.ended


def test_nearest_returns_the_closest_allowed_place() -> None:
    ways = ShortestPaths(room(4.0, 4.0), 0.5, np.random.default_rng(1))
    assert not ways.allows(0.2, 2.0)
    there = ways.nearest(Pose2D(0.2, 2.0, 1.0))
    assert ways.allows(there.x, there.y)
    assert there.distance_to(Pose2D(0.2, 2.0)) < 0.5
    assert there.theta == 1.0
    assert not ways.allows(-5.0, 2.0)
