"""Grids of floors: walls, areas, holes, open doors and cars of lifts."""

import numpy as np
import pytest

from ppaas.imports.buildings import floor_grid
from ppaas.imports.buildings.floor_grid import FloorShape, grid_of_walls, with_marks
from ppaas.imports.graphs.model.route_graph import GraphMark
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

SQUARE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]


def value(grid: GridMap, x: float, y: float) -> int:
    row, column = grid.info.to_cells((x, y)).tolist()
    return int(grid.data[row, column])


def test_areas_are_free_holes_unknown_and_walls_occupied() -> None:
    shape = FloorShape([((2.0, 0.0), (2.0, 4.0))], [SQUARE], [[(3.0, 3.0), (3.5, 3.0), (3.5, 3.5)]])
    grid = grid_of_walls(shape, 0.1, ImportReport("x"))
    assert [value(grid, *place) for place in ((1.0, 1.0), (2.0, 1.0), (3.4, 3.2), (-0.5, 1.0))] == [
        FREE, OCCUPIED, UNKNOWN, UNKNOWN,
    ]  # fmt: skip
    assert (grid.info.origin.x, grid.info.width) == (-1.0, 60)


def test_without_areas_all_that_is_no_wall_is_free() -> None:
    grid = grid_of_walls(FloorShape([((0.0, 0.0), (4.0, 0.0))], places=[(2.0, 3.0)]), 0.1, ImportReport("x"))
    assert value(grid, 2.0, 3.9) == FREE
    assert value(grid, 2.0, 0.0) == OCCUPIED


def test_a_large_floor_has_larger_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(floor_grid, "USUAL_CELLS", 1000)
    report = ImportReport("x")
    grid = grid_of_walls(FloorShape(areas=[SQUARE]), 0.1, report)
    assert grid.info.resolution == 0.2
    assert report.entries[0].text == "a cell is 0.2 m, since the floor is large"


def test_a_turned_car_has_walls_but_at_its_door() -> None:
    blank = GridMap(np.full((80, 80), UNKNOWN, np.int8), GridInfo(0.05, 80, 80))
    car = GraphMark("car", "lift", ((2.0, 1.0), (3.0, 2.0), (2.0, 3.0), (1.0, 2.0)))
    door = GraphMark("door", "door", ((2.35, 1.3), (2.75, 1.7)))
    grid = with_marks(blank, [car, door])
    assert value(grid, 2.0, 2.0) == FREE
    assert value(grid, 2.53, 1.47) == FREE
    assert value(grid, 2.57, 2.57) == OCCUPIED
    assert value(grid, 0.5, 0.5) == UNKNOWN
    assert (blank.data == UNKNOWN).all()
