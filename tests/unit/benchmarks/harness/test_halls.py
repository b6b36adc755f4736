"""Halls: places of goals, and lanes as a person would draw them."""

import math
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.fleet.stand_ins.simulation import SPACING, roadmap_of
from benchmarks.harness.halls import ASIDE, goal_in, right_hand_lanes
from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.maps.generate import warehouse
from ppaas.traffic.settings import TrafficParameters

HALL = roadmap_of("..#.\n....\n#..#")
BLOCKED = [(0, 2), (2, 0), (2, 3), *((row, column) for row in range(-1, 4) for column in (-1, 4))]
BLOCKED += [(row, column) for row in (-1, 3) for column in range(4)]


@given(st.integers(0, len(HALL.roadmap) - 1), st.integers(0, 999), st.floats(0.05, 0.3), st.floats(0.0, 0.5))
def test_a_place_is_in_its_cell_and_off_all_walls(cell: int, seed: int, radius: float, beside: float) -> None:
    x, y = goal_in(cell, HALL, radius, Random(seed), beside)
    centre = HALL.centre(cell)
    assert max(abs(x - centre[0]), abs(y - centre[1])) <= beside * SPACING + 1e-9
    for row, column in BLOCKED:
        dx, dy = (max(abs(a - b * SPACING) - SPACING / 2.0, 0.0) for a, b in ((x, column), (y, row)))
        assert math.hypot(dx, dy) >= radius - 1e-9


def test_the_centre_is_taken_if_no_other_place_is_wanted() -> None:
    assert goal_in(3, HALL, 0.2, Random(1), 0.0) == pytest.approx(HALL.centre(3))


@pytest.mark.parametrize("seed", range(1, 4))
def test_all_cells_on_lanes_are_reached_from_all_others(seed: int) -> None:
    grid = warehouse(seed, width=40.0)
    layers = build_layers(grid, robot_radius=0.2, zones=right_hand_lanes(grid))
    roadmap = roadmaps_of(layers)((0.2,), TrafficParameters()).roadmap
    starts, ends = roadmap.moves.T
    graph = coo_array((np.ones(len(starts)), (starts, ends)), shape=(len(roadmap), len(roadmap)))
    assert len(roadmap) > 200
    assert connected_components(graph, connection="strong")[0] == 1


def test_robots_keep_right() -> None:
    zones = {zone.name: zone.geometry.coordinates for zone in right_hand_lanes(warehouse(1, width=40.0)).zones}
    for name, ((x, y), (to_x, to_y)) in zones.items():
        if name.endswith("east"):
            assert to_x > x
            assert zones[name[:-4] + "west"][0][1] == pytest.approx(y + 2 * ASIDE)
        if name.endswith("north"):
            assert to_y > y
            assert zones[name[:-5] + "south"][0][0] == pytest.approx(x - 2 * ASIDE)
