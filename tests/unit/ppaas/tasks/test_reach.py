"""Reach of robots: lengths of ways by the costs of planners."""

from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.planners.batch.cost_matrix import cost_matrix
from ppaas.planners.weights import NEUTRAL
from ppaas.tasks.reach import COST_OF_CELL, free_length
from robots.plans.offline import costmap_of_file


def test_the_cost_of_a_cell_is_that_of_planners() -> None:
    assert COST_OF_CELL == NEUTRAL


def test_the_cost_of_a_free_way_is_its_length() -> None:
    costmap = costmap_of_file(Path("docs/examples/office.yaml"), radius=0.18)
    [[cost]] = cost_matrix(costmap, [Pose2D(2.0, 2.0, 0.0)], [Pose2D(3.0, 2.0, 0.0)])
    assert free_length(float(cost), costmap.info.resolution) == pytest.approx(1.0)
