"""All cells that a path crosses are found, however far apart its points are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.planners.weights import passable
from ppaas.plans.reuse.crossed_cells import crossed_by, first_blocked
from tests.reference.plans.plan_bytes import cells_on
from tests.support.world.grids import costmap

INFO = GridInfo(0.5, 20, 20, Pose2D(-1.0, 2.0, 0.3))

coordinates = st.floats(min_value=0.0, max_value=20.0, allow_nan=False)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=4))
def test_all_crossed_cells_are_found(places: list[tuple[float, float]]) -> None:
    points = INFO.to_world(np.array(places) - 0.5)
    crossed = crossed_by(INFO, points)
    found = {(row, column) for row, column in np.concatenate((crossed.cells, crossed.corners)).tolist()}
    assert cells_on(INFO, points.tolist()) <= found


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=4))
def test_each_crossed_cell_neighbours_the_previous_one(places: list[tuple[float, float]]) -> None:
    points = INFO.to_world(np.array(places) - 0.5)
    cells = crossed_by(INFO, points).cells
    assert cells[0].tolist() == INFO.to_cells(points[0]).tolist()
    assert cells[-1].tolist() == INFO.to_cells(points[-1]).tolist()
    assert set(np.abs(np.diff(cells, axis=0)).max(axis=1, initial=1).tolist()) <= {1}


def test_path_along_centres_crosses_its_cells_and_corners() -> None:
    info = GridInfo(1.0, 5, 5)
    crossed = crossed_by(info, info.to_world([[0, 0], [0, 1], [1, 2]]))
    assert crossed.cells.tolist() == [[0, 0], [0, 1], [1, 2]]
    assert sorted(crossed.corners.tolist()) == [[0, 2], [1, 1]]


@pytest.mark.parametrize(
    ("picture", "blocked"),
    [("...\n...\n...", None), ("...\n.#.\n...", (1, 1)), ("..?\n...\n...", (2, 2)), ("...\ni..\n...", (1, 0))],
)
def test_path_is_blocked_by_obstacles_on_it_or_at_a_corner(picture: str, blocked: tuple[int, int] | None) -> None:
    live = costmap(picture)
    path = crossed_by(live.info, live.info.to_world([[0, 0], [1, 1], [2, 2]]))
    assert first_blocked(live, path, passable(False)) == blocked


def test_a_path_that_leaves_the_map_is_blocked() -> None:
    live = costmap("...\n...")
    path = crossed_by(live.info, live.info.to_world([[0, 0], [0, 7]]))
    assert first_blocked(live, path, passable(True)) == (0, 3)
