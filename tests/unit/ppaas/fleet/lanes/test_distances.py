"""Distances between moves along lanes: robots on two of them that share no cell never touch."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import Line, network_of
from ppaas.fleet.lane_placing import Placed, placed_on
from ppaas.fleet.lane_roadmap import check_apart
from tests.support.budget import examples
from tests.support.fleet.lanes import SITE, SPACING, line

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
def test_cells_that_are_accepted_are_apart_and_those_that_are_refused_are_not(lines: list[Line]) -> None:
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
