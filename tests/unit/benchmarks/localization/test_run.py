"""Conditions under which a robot counts as found, and its route."""

import numpy as np
import pytest

from benchmarks.localization.route import Route
from benchmarks.localization.run import found_after
from ppaas.maps.generate import office
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
    route = Route(grid, np.random.default_rng(3))
    start = route.anywhere()
    route.begin(start)
    world = World(grid, 1)
    robot = world.add_robot(start)
    while robot.base.travelled < 25.0 and world.time() < 120.0:
        robot.command(route.steer(robot.base.pose))
        for _ in range(5):
            world.step()
    assert robot.base.travelled >= 25.0
