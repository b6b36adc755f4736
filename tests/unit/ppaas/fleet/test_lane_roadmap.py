"""Lane roadmaps: places and discs find their cells, and robots on moves that share no cell never touch."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ppaas.errors import GoalOccupied, InvalidInput
from ppaas.fleet.lane_drawing import DrawnLane, network_of
from ppaas.fleet.lane_placing import Placed, placed_on
from ppaas.fleet.lane_roadmap import LaneRoadmap, check_apart, lane_roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from tests.support.budget import examples
from tests.support.fleet.floors import floor_of
from tests.support.fleet.lanes import SITE, SIZES, SPACING, hall, line

CELLS = hall(*SITE)
PLACES = st.tuples(st.floats(0.0, 20.0), st.floats(0.0, 12.0))


def moves_of(cells: LaneRoadmap) -> set[tuple[int, int]]:
    return {(cell, int(near)) for cell, own in enumerate(cells.roadmap.neighbours) for near in own if near >= 0}


def outlines(cells: LaneRoadmap) -> list[list[tuple[np.ndarray, np.ndarray, float]]]:
    """Return for each cell the halves of its moves: where each begins, its direction, and its length."""
    found: list[list[tuple[np.ndarray, np.ndarray, float]]] = [[] for _ in cells.centres]
    for one, other in moves_of(cells):
        begin, end = cells.centres[one], cells.centres[other]
        length = math.dist(begin, end)
        found[one].append((begin, (end - begin) / length, length / 2.0))
        found[other].append((end, (begin - end) / length, length / 2.0))
    return found


OUTLINES = outlines(CELLS)


def depth(cell: int, x: float, y: float, radius: float) -> float:
    """Return how deep a disc is in the area of a cell, by its definition [m]; negative outside of it."""
    apart = max(math.dist(CELLS.centres[cell], (x, y)) - SPACING / 2.0, 0.0)
    for begin, along, length in OUTLINES[cell]:
        offset = np.array((x, y)) - begin
        ahead, aside = float(offset @ along), abs(float(offset[0] * along[1] - offset[1] * along[0]))
        nearest = min(max(ahead, 0.0), length), max(aside - SPACING / 2.0, 0.0)
        apart = min(apart, math.hypot(ahead - nearest[0], nearest[1]))
    return radius - apart


@given(PLACES, st.floats(0.05, 1.0))
def test_touched_cells_are_those_whose_area_a_disc_reaches(place: tuple[float, float], radius: float) -> None:
    depths = [depth(cell, *place, radius) for cell in range(len(CELLS.roadmap))]
    assume(all(abs(each) > 1e-6 for each in depths))
    assert CELLS.touched(*place, radius).tolist() == [cell for cell, each in enumerate(depths) if each > 0]


def test_the_largest_robot_in_a_cell_touches_no_other() -> None:
    for cell, (x, y) in enumerate(CELLS.centres.tolist()):
        assert CELLS.touched(x, y, SPACING / 2.0).tolist() == [cell]


def test_a_robot_on_a_move_touches_its_two_cells_only_if_lanes_meet_at_right_angles() -> None:
    cells = hall(line((1, 6), (19, 6)), line((6, 1), (6, 11)), line((3, 6), (3, 10), (6, 10)))
    for one, other in moves_of(cells):
        begin, end = cells.centres[[one, other]].tolist()
        assert cells.touched_along(tuple(begin), tuple(end), SPACING / 2.0 - 1e-6) == {one, other}


def test_a_robot_on_a_move_touches_its_two_cells_at_least() -> None:
    for one, other in moves_of(CELLS):
        begin, end = CELLS.centres[[one, other]].tolist()
        assert CELLS.touched_along(tuple(begin), tuple(end), 0.01) >= {one, other}


@given(PLACES)
def test_the_nearest_cell_is_the_one_whose_lane_is_nearest(place: tuple[float, float]) -> None:
    def apart(cell: int) -> float:
        parts = [np.linspace(begin, begin + length * along, 200) for begin, along, length in OUTLINES[cell]]
        return float(np.hypot(*(np.concatenate(parts) - place).T).min())

    distances = [apart(cell) for cell in range(len(CELLS.roadmap))]
    try:
        cell = CELLS.nearest(*place, 1.0)
    except GoalOccupied as error:
        assert min(distances) > 1.0 - 0.01
        assert "no lane with room for the robot within 1 m" in str(error)
    else:
        assert distances[cell] <= min(distances) + 0.01


@given(PLACES, st.floats(0.1, 3.0))
def test_nearby_cells_are_those_within_a_distance(place: tuple[float, float], within: float) -> None:
    apart = np.hypot(*(CELLS.centres - place).T)
    found = CELLS.nearby(*place, within)
    assert sorted(found) == np.nonzero(apart <= within)[0].tolist()
    assert apart[found].tolist() == sorted(apart[found].tolist())
    assert CELLS.closest(*place) == apart.argmin()


def test_moves_back_are_missing_on_one_way_lanes_only() -> None:
    cells = hall(line((1, 1), (10, 1), one_way=True), line((10, 1), (10, 8)), line((1, 1), (1, 8), (10, 8)))
    one_way = {move for move in moves_of(cells) if move[::-1] not in moves_of(cells)}
    assert one_way
    assert all(cells.centres[list(move), 1].tolist() == [1.0, 1.0] for move in one_way)


def test_parts_of_lanes_without_room_are_left_out() -> None:
    lethal = np.zeros((60, 100), np.bool_)
    lethal[10, 40] = True
    cells = lane_roadmap([line((1, 1), (9.5, 1)), line((1, 1), (1, 5))], *floor_of(lethal), SIZES)
    centres = cells.centres
    assert np.hypot(*(centres - (4.0, 1.0)).T).min() > 0.3 - 0.1
    assert not any(centres[one, 0] < 4.0 < centres[other, 0] for one, other in moves_of(cells))
    assert (centres[:, 0] > 5.0).any()


def test_large_robots_do_not_enter_lanes_on_which_only_small_ones_have_room() -> None:
    lethal = np.zeros((60, 100), np.bool_)
    lethal[[6, 14], 40:60] = True
    sizes = RobotSizes(0.4, 0.1, smaller=(0.2, 0.4))
    cells = lane_roadmap([line((1, 1), (9.5, 1)), line((1, 1), (1, 5))], *floor_of(lethal), sizes)
    assert cells.radii == (0.2, 0.4)
    narrow = np.hypot(np.clip(cells.centres[:, 0], 4.0, 5.9) - cells.centres[:, 0], 0.4) < 0.49
    narrow &= cells.centres[:, 1] < 1.1
    assert narrow.any()
    assert not cells.roadmap.barred[0].any()
    assert cells.roadmap.barred[1].tolist() == narrow.tolist()


def test_a_map_without_room_on_any_lane_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"radius 0.2 m .* no room on lanes such as 'a', 'b'"):
        lane_roadmap(
            [line((1, 1), (3, 1), name="a"), line((1, 3), (3, 3), name="b")],
            np.zeros((50, 50), np.float32), floor_of(np.zeros((50, 50), np.bool_)).info, SIZES,
        )  # fmt: skip


def test_lanes_outside_of_the_map_have_no_cells() -> None:
    cells = hall(line((15, 3), (25, 3)))
    assert cells.centres[:, 0].max() < 20.0


def test_the_longest_move_is_told() -> None:
    assert hall(line((1, 1), (2, 1))).longest_move == pytest.approx(1.0)


POINTS = st.tuples(st.integers(0, 12), st.integers(0, 12)).map(lambda point: (point[0] / 1.5, point[1] / 1.5))
LINES = st.lists(st.lists(POINTS, min_size=2, max_size=4, unique=True), min_size=1, max_size=4).map(
    lambda drawn: [line(*points, name=str(number)) for number, points in enumerate(drawn)]
)


def closest(cells: Placed) -> float:
    """Return how near robots on two moves, or on a move and in a cell that is not of it, come to each other [m]."""
    moves = {frozenset(move) for move in cells.names}
    nearest = math.inf
    for one, other in itertools.combinations(moves, 2):
        (a, b), (c, d) = cells.centres[sorted(one)], cells.centres[sorted(other)]
        if not one & other:
            parts = np.linspace(0.0, 1.0, 41)[:, np.newaxis]
            ways = a + parts * (b - a), c + parts * (d - c)
            nearest = min(nearest, np.hypot(*(ways[0][:, np.newaxis] - ways[1]).T).min())
    for move, cell in itertools.product(moves, range(len(cells.centres))):
        if cell not in move:
            a, b = cells.centres[sorted(move)]
            way = a + np.linspace(0.0, 1.0, 81)[:, np.newaxis] * (b - a)
            nearest = min(nearest, np.hypot(*(way - cells.centres[cell]).T).min())
    return nearest


@given(LINES)
@settings(max_examples=examples(60))
def test_cells_that_are_accepted_are_apart_and_those_that_are_refused_are_not(lines: list[DrawnLane]) -> None:
    try:
        cells = placed_on(network_of(lines), SPACING)
    except InvalidInput:
        return
    try:
        check_apart(cells, SPACING)
    except InvalidInput:
        assert closest(cells) < SPACING + 0.02
    else:
        assert closest(cells) >= SPACING - 1e-5


def test_a_site_is_accepted() -> None:
    check_apart(placed_on(network_of(SITE), SPACING), SPACING)


def test_lanes_too_near_to_each_other_are_told_with_their_place_and_what_to_do() -> None:
    lines = [line((0, 0), (9, 0), name="out"), line((0, 0.4), (9, 0.4), name="home")]
    with pytest.raises(InvalidInput, match=r"lanes 'home' and 'out' are 0.40 m apart near .*0.20, .* draw them"):
        check_apart(placed_on(network_of(lines), SPACING), SPACING)


def test_a_lane_too_near_to_itself_is_told() -> None:
    folded = line((0, 0), (6, 0), (0, 0.7), name="folded")
    with pytest.raises(InvalidInput, match="parts of lane 'folded' are"):
        check_apart(placed_on(network_of([folded]), SPACING), SPACING)
