import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied, reachable
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from robots.client.map_files import read_map_file
from robots.sim.courses import Course, CoursePlanner, GoalRules, drivable, path_lengths
from tests.support.budget import examples
from tests.support.world.rooms import room

RULES = GoalRules()


def check(grid: GridMap, courses: list[Course], robots: int, goals: int) -> None:
    """Check courses against all rules."""
    assert [len(course.goals) for course in courses] == [goals] * robots
    for one, other in itertools.combinations(courses, 2):
        assert one.start.distance_to(other.start) >= RULES.starts_apart - 1e-9
        for mine, theirs in itertools.product(one.goals, other.goals):
            assert mine.distance_to(theirs) >= RULES.goals_apart - 1e-9
    clear = (distance_to_occupied(grid) > RULES.clearance) & (grid.data == 0)
    for course in courses:
        for here, goal, length in zip((course.start, *course.goals), course.goals, course.lengths, strict=False):
            cell, target = grid.info.cell_of(here.x, here.y), grid.info.cell_of(goal.x, goal.y)
            assert cell is not None
            assert target is not None
            within = reachable(clear, *cell)
            assert within[target]
            lengths = path_lengths(grid.info, within, cell)
            longest = lengths[np.isfinite(lengths)].max()
            assert lengths[target] == pytest.approx(length)
            assert length >= longest / 3.0 - 1e-9
            assert length >= here.distance_to(goal) - 1e-9


@settings(max_examples=examples(15))
@given(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 3))
def test_goals_in_random_warehouses_are_far_reachable_and_apart(seed: int, robots: int, goals: int) -> None:
    grid = warehouse(seed)
    courses = CoursePlanner(grid, seed).choose(robots, goals)
    check(grid, courses, robots, goals)
    assert all(length < 30.0 for course in courses for length in course.lengths)


@pytest.mark.parametrize("name", ["depot", "turtlebot3", "tb3_sandbox", "warehouse"])
def test_goals_on_real_maps_are_far_reachable_and_apart(data: Path, name: str) -> None:
    grid = read_map_file(data / "ros" / f"{name}.yaml")
    courses = CoursePlanner(grid, 1).choose(3, 2)
    check(grid, courses, 3, 2)
    assert all(sum(course.lengths) < 0.6 * 300.0 for course in courses), "it takes more than five minutes at 0.6 m/s"


def test_courses_depend_only_on_the_seed() -> None:
    grid = warehouse(3)
    assert CoursePlanner(grid, 5).choose(2, 2) == CoursePlanner(grid, 5).choose(2, 2)
    assert CoursePlanner(grid, 5).choose(2, 2) != CoursePlanner(grid, 6).choose(2, 2)


def test_path_lengths_use_moves_to_eight_neighbours() -> None:
    grid = room(2.0, 2.0, 0.1)
    lengths = path_lengths(grid.info, grid.data == 0, (3, 3))
    assert lengths[3, 3] == 0.0
    assert lengths[3, 8] == pytest.approx(0.5)
    assert lengths[6, 8] == pytest.approx(0.2 + 0.3 * 2**0.5, rel=1e-3)
    assert lengths[0, 0] == np.inf


@pytest.mark.parametrize("small_first", [True, False])
def test_the_largest_room_is_chosen(small_first: bool) -> None:
    grid = room(9.0, 4.0, 0.1)
    cells = grid.data.copy()
    cells[:, 30 if small_first else 60] = 100
    where = drivable(GridMap(cells, grid.info), 0.3, np.random.default_rng(0))
    assert where[20, 45]
    assert not where[20, 10 if small_first else 80]


def test_unknown_cells_are_not_drivable() -> None:
    grid = room(6.0, 4.0, 0.1)
    cells = grid.data.copy()
    cells[:, 40:] = -1
    assert not drivable(GridMap(cells, grid.info), 0.3, np.random.default_rng(0))[:, 40:].any()


@pytest.mark.parametrize(("width", "robots", "what"), [(0.5, 1, "no free cell"), (2.0, 2, "another start")])
def test_a_map_without_enough_free_space_is_refused(width: float, robots: int, what: str) -> None:
    with pytest.raises(InvalidMap, match=what):
        CoursePlanner(room(width, width), 0).choose(robots, 1)


def test_goals_are_in_the_frame_of_a_rotated_map() -> None:
    origin = Pose2D(10.0, -5.0, 1.0)
    [course] = CoursePlanner(room(6.0, 6.0, origin=origin), 0).choose(1, 2)
    for pose in (course.start, *course.goals):
        local = origin.inverse() @ pose
        assert 0.3 < local.x < 5.7
        assert 0.3 < local.y < 5.7
