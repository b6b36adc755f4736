"""Lengths of ways by the costs of planners."""

import math
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.planners.batch.cost_matrix import cost_matrix
from ppaas.planners.weights import NEUTRAL
from ppaas.tasks.ways import COST_OF_CELL, free_length, ways_by
from robots.plans.offline import costmap_of_file


def test_the_cost_of_a_cell_is_that_of_planners() -> None:
    assert COST_OF_CELL == NEUTRAL


def test_the_cost_of_a_free_way_is_its_length() -> None:
    costmap = costmap_of_file(Path("docs/examples/office.yaml"), radius=0.18)
    [[cost]] = cost_matrix(costmap, [Pose2D(2.0, 2.0, 0.0)], [Pose2D(3.0, 2.0, 0.0)])
    assert free_length(float(cost), costmap.info.resolution) == pytest.approx(1.0)


def test_ways_of_a_matrix_are_known_and_others_are_straight() -> None:
    here, there, away = (0.0, 0.0, 0.0), (3.0, 4.0, 0.0), (6.0, 8.0, 0.0)
    way = ways_by([here], [there, away], [[NEUTRAL, None]], 7.0)
    assert (way(here, there), way(here, away), way(there, here)) == (7.0, math.inf, 5.0)
