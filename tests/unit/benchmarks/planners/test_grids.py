"""Grids of the planner benches."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import pytest
from scipy import ndimage

from benchmarks.planners import grids
from ppaas.costmap.costmap import LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidMap, InvalidParameter
from ppaas.maps.formats.netpbm import write_pgm
from ppaas.maps.grid import GridInfo
from robots.plans.offline import PlannedRobot, costmap_for
from tests.support.sources import ROOT

OFFICE = ROOT / "docs" / "examples" / "office.yaml"


def costmap(rows: list[str]) -> Costmap:
    data = np.array([[LETHAL_OBSTACLE if cell == "#" else 0 for cell in row] for row in rows], np.uint8)
    return Costmap(data, GridInfo(1.0, data.shape[1], data.shape[0]))


def test_a_random_grid_has_its_share_of_obstacles_and_is_reproducible() -> None:
    first, again = grids.random(200, 20.0), grids.random(200, 20.0)
    assert (first.costmap.data == LETHAL_OBSTACLE).mean() == pytest.approx(0.2, abs=0.02)
    np.testing.assert_array_equal(first.costmap.data, again.costmap.data)
    assert not first.costmap.data.flags.writeable


def test_an_empty_grid_uses_as_much_memory_as_a_map() -> None:
    before = psutil.Process().memory_info().rss
    grid = grids.empty(8192)
    assert psutil.Process().memory_info().rss - before > 0.9 * grid.costmap.data.nbytes


@pytest.mark.parametrize(("size", "width"), [(3, 1), (4, 1), (5, 1), (64, 1), (65, 1), (50, 3), (61, 4)])
def test_a_maze_connects_all_cells_by_exactly_one_path(size: int, width: int) -> None:
    free = grids.maze(size, width).costmap.data == 0
    assert free.shape == (size, size)
    assert not free[0].any() and not free[:, 0].any()
    assert ndimage.label(free)[1] == 1
    # Reduced to one cell per corridor it is a tree: one passage less than it has places.
    places = free[1 :: width + 1, 1 :: width + 1].sum()
    doors = free[width + 1 :: width + 1, 1 :: width + 1].sum() + free[1 :: width + 1, width + 1 :: width + 1].sum()
    assert doors == places - 1


@pytest.mark.parametrize(
    ("make", "numbers"),
    [
        (grids.empty, (0,)),
        (grids.empty, (1 << 20,)),
        (grids.random, (9, 100.0)),
        (grids.random, (9, float("nan"))),
        (grids.maze, (2,)),
        (grids.maze, (9, 0)),
    ],
)
def test_an_invalid_grid_is_refused(make: Callable[..., grids.Grid], numbers: tuple[float, ...]) -> None:
    with pytest.raises(InvalidParameter):
        make(*numbers)


def test_a_map_of_map_server_is_inflated_like_in_a_container() -> None:
    expected = costmap_for(OFFICE, PlannedRobot())
    for path in (OFFICE, OFFICE.with_suffix(".pgm")):
        np.testing.assert_array_equal(grids.from_file(path).costmap.data, expected.data)


def test_a_single_image_is_a_costmap_of_navfn_or_costmap_2d(tmp_path: Path) -> None:
    image = tmp_path / "costs.pgm"
    image.write_bytes(write_pgm(np.array([[50, 130, 253], [254, 255, 50]], np.uint8)))
    assert grids.from_file(image).costmap.data.tolist() == [
        [0, 100, NO_INFORMATION],
        [LETHAL_OBSTACLE, LETHAL_OBSTACLE, 0],
    ]
    image.write_bytes(write_pgm(np.array([[0, 130, 253], [254, 255, 50]], np.uint8)))
    assert grids.from_file(image).costmap.data.tolist() == [[0, 130, 253], [254, 255, 50]]


def test_the_costmap_of_willow_garage_has_the_expected_costs(data: Path) -> None:
    costmap = grids.from_file(data / "ros" / "willow_costmap.pgm").costmap
    assert set(np.unique(costmap.data)) == {0, LETHAL_OBSTACLE, NO_INFORMATION}
    assert costmap.data[grids.goal_in(costmap)] != LETHAL_OBSTACLE


@pytest.mark.parametrize("name", ["none.map", "none.yaml", "none.pgm"])
def test_a_missing_file_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidMap):
        grids.from_file(tmp_path / name)


def test_the_goal_is_in_the_middle_of_the_largest_region() -> None:
    # The lower right corner is a separate region.
    assert grids.goal_in(costmap([".#..", ".#..", "##..", "..#."])) == (2, 2)
    assert grids.goal_in(costmap(["."])) == (0, 0)


def test_an_invalid_goal_is_refused() -> None:
    one = costmap([".#"])
    assert grids.goal_in(one, (0, 0)) == (0, 0)
    with pytest.raises(GoalOccupied):
        grids.goal_in(one, (0, 1))
    with pytest.raises(GoalOutsideMap):
        grids.goal_in(one, (1, 0))
    with pytest.raises(GoalOccupied):
        grids.goal_in(costmap(["#"]))
