"""Scores: contacts of robots, and the cells of a map."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.demo.contact_referee import Referee, Touches
from robots.demo.scorer import wrong_cells
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room


def touches(robot_x: float, speed: float, push: float, seconds: float = 1.5) -> Touches:
    """Drive a robot, and push a person who stands at x = 5 m along x at some speed [m/s]."""
    world = World(room(10.0, 4.0), 1)
    robot = world.add_robot(Pose2D(robot_x, 2.0))
    pedestrian = world.add_pedestrian(ShortestPaths(world.grid, 0.35, np.random.default_rng(1)), Pose2D(5.0, 2.0))
    referee = Referee(world, robot)
    counted = referee.begin()
    pedestrian.body.velocity_func = lambda body, *_: setattr(body, "velocity", (push, 0.0))
    for _ in range(round(seconds / world.dt)):
        robot.command(Twist(Vector3(x=speed)))
        world.step()
        referee.look()
    return counted


@pytest.mark.parametrize(
    ("robot_x", "speed", "push", "caused", "suffered"),
    [
        (4.3, 0.5, 0.0, 1, 0),  # into a standing person
        (4.3, 0.0, -0.8, 0, 1),  # a person walks into a standing robot
        (4.3, 0.5, -0.8, 1, 0),  # both
        (4.3, -0.3, -0.9, 0, 1),  # the robot retreats, and the person catches up
        (5.7, -0.5, 0.0, 1, 0),  # backwards
        (3.0, 0.3, 0.0, 0, 0),  # no contact
    ],
)
def test_the_approaching_side_causes_a_contact(
    robot_x: float, speed: float, push: float, caused: int, suffered: int
) -> None:
    counted = touches(robot_x, speed, push)
    assert (counted.caused, counted.suffered, counted.walls) == (caused, suffered, 0)


def test_wall_contacts_and_the_nearest_distance_are_counted() -> None:
    assert touches(9.6, 0.5, 0.0).walls == 1
    assert touches(3.0, 0.5, 0.0, 2.0).nearest == pytest.approx(2.0 - 0.43 - 0.875, abs=0.05)


TRUTH = np.zeros((20, 30), np.int8)
TRUTH[:, 15:18] = 100


def grid(cells: np.ndarray, x: float = 0.0) -> GridMap:
    return GridMap(cells, GridInfo(0.1, cells.shape[1], cells.shape[0], Pose2D(x, 0.0)))


def test_map_of_the_world_is_right_even_if_it_is_one_cell_off() -> None:
    assert wrong_cells(grid(TRUTH), grid(TRUTH)) == (0, 600)
    assert wrong_cells(grid(TRUTH, 0.1), grid(TRUTH)) == (0, 600)


def test_wall_that_is_elsewhere_and_free_cells_inside_a_wall_are_wrong() -> None:
    made = np.zeros((20, 30), np.int8)
    made[:, 5] = 100
    wall, inside = 20, 20 - 2  # at the edges of the world, free cells are beside it
    assert wrong_cells(grid(made), grid(TRUTH)) == (wall + inside, 600)


def test_unknown_cells_do_not_count_and_all_is_free_outside_the_world() -> None:
    made = np.full((20, 30), UNKNOWN, np.int8)
    made[0, :4] = 0, 100, 0, 0
    assert wrong_cells(grid(made, -1.0), grid(TRUTH)) == (1, 4)
