"""Metric roadmaps: cells and moves keep their distance, and places and discs find their cells."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, PlanCancelled, PPaaSError
from ppaas.fleet.lattice_roadmap import MOST_PLACES, LatticeRoadmap, lattice_roadmap
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import Roadmap
from ppaas.fleet.robot_sizes import RobotSizes, clearance_of
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.fleet.floors import Floor, floor_of, floors

RADII = st.sampled_from([0.05, 0.1, 0.2, 0.3])
MARGINS = st.sampled_from([0.0, 0.02, 0.1])
EMPTY = floor_of(np.zeros((20, 30), np.bool_))


def made(floor: Floor, radius: float, margin: float, spacing: float | None = None) -> MetricRoadmap:
    """Return the roadmap of a floor; floors on which no robot fits are skipped."""
    try:
        return lattice_roadmap(*floor, RobotSizes(radius, margin, spacing))
    except InvalidInput as error:
        assume("fits nowhere" not in str(error))
        raise


def clearance(floor: Floor, x: float, y: float) -> float:
    """Return the distance of the map cell that contains a place, 0 outside the map."""
    cell = floor.info.cell_of(x, y)
    return 0.0 if cell is None else float(floor.to_lethal[cell])


def moves_of(metric: MetricRoadmap) -> list[tuple[int, int]]:
    return [(cell, int(near)) for cell, own in enumerate(metric.roadmap.neighbours) for near in own if near >= 0]


@given(floors(), RADII, MARGINS, st.sampled_from([1.0, 1.3]))
def test_each_cell_and_each_point_of_each_move_keeps_the_distance(
    floor: Floor, radius: float, margin: float, wider: float
) -> None:
    metric = made(floor, radius, margin, wider * 2 * (radius + margin))
    least, centres = float(np.float32(radius + margin)), metric.centres
    assert all(clearance(floor, *centre) >= least for centre in centres.tolist())
    for here, there in moves_of(metric):
        steps = np.linspace(centres[here], centres[there], 40).tolist()
        assert all(clearance(floor, *place) >= least for place in steps)
        assert math.dist(centres[here], centres[there]) == pytest.approx(metric.spacing)


@given(floors(turned=True), RADII, MARGINS)
def test_on_a_turned_map_moves_keep_the_distance_but_for_a_cell_whose_corner_they_cut(
    floor: Floor, radius: float, margin: float
) -> None:
    metric = made(floor, radius, margin)
    centres = metric.centres
    assert all(clearance(floor, *centre) >= np.float32(radius + margin) for centre in centres.tolist())
    for here, there in moves_of(metric):
        steps = np.linspace(centres[here], centres[there], 40).tolist()
        assert all(clearance(floor, *place) >= radius + margin - 1.5 * floor.info.resolution for place in steps)


@given(floors(), RADII, MARGINS)
def test_no_cell_and_no_move_of_the_lattice_is_missing(floor: Floor, radius: float, margin: float) -> None:
    metric = made(floor, radius, margin)
    least, spacing = float(np.float32(radius + margin)), metric.spacing
    numbers, moves = metric.roadmap.numbers, set(moves_of(metric))
    for row, column in np.ndindex(numbers.shape):
        x, y = metric.x0 + column * spacing, metric.y0 + row * spacing
        assert (numbers[row, column] >= 0) == (clearance(floor, x, y) >= least)
    for one, other in np.ndindex(len(metric.roadmap), len(metric.roadmap)):
        if np.abs(metric.roadmap.cells[one] - metric.roadmap.cells[other]).sum() == 1 and (one, other) not in moves:
            steps = np.linspace(metric.centres[one], metric.centres[other], 1000).tolist()
            assert any(clearance(floor, *place) < least for place in steps)


@given(floors(turned=True), RADII, MARGINS)
def test_neighbours_are_symmetric_and_packed_and_the_same_map_gives_the_same_roadmap(
    floor: Floor, radius: float, margin: float
) -> None:
    metric, again = made(floor, radius, margin), made(floor, radius, margin)
    moves = moves_of(metric)
    assert {(there, here) for here, there in moves} == set(moves)
    assert (np.diff((metric.roadmap.neighbours >= 0).astype(int), axis=1) <= 0).all()
    assert (metric.x0, metric.y0, metric.spacing) == (again.x0, again.y0, again.spacing)
    assert np.array_equal(metric.roadmap.neighbours, again.roadmap.neighbours)


@given(
    st.integers(1, 5).flatmap(
        lambda h: st.lists(st.lists(st.booleans(), min_size=4, max_size=4), min_size=h, max_size=h)
    ),
    st.tuples(st.floats(-3, 8), st.floats(-3, 8), st.floats(0, 4)),
)
def test_touched_cells_and_the_nearest_one_are_those_of_a_search_among_all(
    free: list[list[bool]], place: tuple[float, float, float]
) -> None:
    metric = LatticeRoadmap(Roadmap.of_grid(np.array(free)), 0.7, -1.0, 0.5)
    x, y, radius = place
    aside = [[max(abs(a - b) - 0.35, 0.0) for a, b in zip(centre, (x, y), strict=True)] for centre in metric.centres]
    depths = [radius - math.hypot(*sides) for sides in aside]
    assume(all(abs(depth) > 1e-6 for depth in depths))
    assert metric.touched(x, y, radius).tolist() == [cell for cell, depth in enumerate(depths) if depth > 0]
    apart = [math.dist(centre, (x, y)) for centre in metric.centres.tolist()]
    try:
        assert apart[metric.nearest(x, y, radius)] == pytest.approx(min(apart))
    except GoalOccupied:
        assert min(apart, default=math.inf) > radius - 1e-9
    except GoalOutsideMap:
        assert not (-1.34 < x < -1.0 + 3.5 * 0.7 - 0.01 and 0.16 < y < 0.5 + (len(free) - 0.5) * 0.7 - 0.01)


@given(st.tuples(*[st.floats(-2, 5)] * 4), st.floats(0.05, 1.0))
def test_cells_touched_along_a_way_are_those_that_are_near_to_it(ends: tuple[float, ...], radius: float) -> None:
    metric = LatticeRoadmap(Roadmap.of_grid(np.ones((6, 7), np.bool_)), 0.7, -1.0, 0.5)
    begin, end = np.array(ends[:2]), np.array(ends[2:])
    found = metric.touched_along((ends[0], ends[1]), (ends[2], ends[3]), radius)
    along = begin + np.linspace(0.0, 1.0, 5001)[:, None] * (end - begin)
    for cell, centre in enumerate(metric.centres):
        near = np.hypot(*np.maximum(np.abs(along - centre) - 0.35, 0.0).T).min()
        if near < radius - 0.001 or near > radius:
            assert (cell in found) == (near < radius)


@pytest.mark.parametrize("end", [(math.nan, 0.0), (0.0, math.inf)])
def test_a_way_that_is_not_finite_touches_nothing(end: tuple[float, float]) -> None:
    metric = lattice_roadmap(*EMPTY, RobotSizes(0.2, 0.05))
    with pytest.raises(InvalidInput, match="finite"):
        metric.touched_along((0.0, 0.0), end, 0.2)
    with pytest.raises(InvalidInput, match="positive"):
        metric.touched_along((0.0, 0.0), (1.0, 0.0), 0.0)


def test_a_robot_in_the_middle_of_its_cell_touches_no_other() -> None:
    metric = lattice_roadmap(*EMPTY, RobotSizes(0.2, 0.05))
    for cell, centre in enumerate(metric.centres):
        assert metric.touched(*centre, 0.25).tolist() == [cell]
        assert metric.touched(*centre, 0.0).tolist() == [cell]


def test_an_empty_map_is_covered_by_cells_of_the_robots_size() -> None:
    metric = lattice_roadmap(*EMPTY, RobotSizes(0.2, 0.05))
    assert metric.spacing == 0.5
    assert len(metric.roadmap) >= 24


def test_a_wall_that_is_thinner_than_a_cell_parts_its_neighbours() -> None:
    lethal = np.zeros((5, 40), np.bool_)
    lethal[:, 20] = True
    metric = lattice_roadmap(*floor_of(lethal), RobotSizes(0.05, 0.0, 0.5))
    sides = metric.centres[:, 0] < 2.05
    assert sides.any() and not sides.all()
    assert all(sides[here] == sides[there] for here, there in moves_of(metric))


def test_an_aisle_narrower_than_a_cell_is_found_in_any_row() -> None:
    for row in range(12):
        lethal = np.zeros((30, 60), np.bool_)
        lethal[5 + row, 10:50] = lethal[9 + row, 10:50] = True
        lethal[: 5 + row, 30] = lethal[9 + row :, 30] = True
        metric = lattice_roadmap(*floor_of(lethal), RobotSizes(0.15, 0.05))
        assert connected(metric, metric.nearest(0.6, 1.5, 1.0), metric.nearest(5.4, 1.5, 1.0)), row


def connected(metric: MetricRoadmap, start: int, goal: int) -> bool:
    known, todo = {start}, [start]
    while todo:
        near = {int(cell) for cell in metric.roadmap.neighbours[todo.pop()] if cell >= 0} - known
        known |= near
        todo += near
    return goal in known


def test_unknown_cells_are_not_free() -> None:
    data = np.zeros((20, 40), np.int8)
    data[:, 20:] = -1
    layers = build_layers(GridMap(data, GridInfo(0.1, 40, 20)), robot_radius=0.2)
    metric = lattice_roadmap(clearance_of(layers), layers.grid.info, RobotSizes(0.2, 0.05))
    assert len(metric.roadmap) > 0
    assert metric.centres[:, 0].max() < 2.0


@pytest.mark.parametrize(
    ("place", "error"),
    [
        ((1.0, -1.0, 0.5), GoalOutsideMap),
        ((9.0, 1.0, 9.0), GoalOutsideMap),
        ((1.5, 1.0, 0.3), GoalOccupied),
        ((math.nan, 1.0, 0.3), InvalidInput),
        ((1.0, 1.0, math.inf), InvalidInput),
    ],
)
def test_places_without_a_cell_are_typed_errors(place: tuple[float, float, float], error: type[PPaaSError]) -> None:
    lethal = np.zeros((20, 30), np.bool_)
    lethal[5:15, 10:20] = True
    with pytest.raises(error):
        lattice_roadmap(*floor_of(lethal), RobotSizes(0.2, 0.05)).nearest(*place)


@pytest.mark.parametrize(
    ("sizes", "text"),
    [
        ((0.0, 0.1, None), "radius must be a positive number"),
        ((math.inf, 0.1, None), "radius must be a positive number"),
        ((0.2, -0.1, None), "margin must be at least 0 m"),
        ((0.2, 0.1, 0.5), "spacing must be at least 0.6 m"),
        ((0.2, 0.1, math.nan), "spacing must be at least 0.6 m"),
        ((1e-4, 0.0, None), f"at most {MOST_PLACES} are allowed"),
        ((1e-300, 0.0, None), "too large"),
        ((2000.0, 0.0, None), "fits nowhere on the map"),
    ],
)
def test_sizes_that_do_not_fit_are_named(sizes: tuple[float, float, float | None], text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        lattice_roadmap(*EMPTY, RobotSizes(*sizes))


def test_sizes_whose_sum_is_rounded_are_accepted() -> None:
    assert lattice_roadmap(*EMPTY, RobotSizes(0.1, 0.2, 0.6)).spacing == 0.6


def test_the_choice_can_be_ended() -> None:
    def check() -> None:
        raise PlanCancelled("no longer wanted")

    with pytest.raises(PlanCancelled):
        lattice_roadmap(*EMPTY, RobotSizes(0.2, 0.05), check)
