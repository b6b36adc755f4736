"""Costmaps: copies keep where they may differ from the map; costmaps as occupancy grids."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.costmap import MAX_CELLS, Costmap, occupancy_of
from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.occupancy import to_message
from tests.support.world import grids

LEFT, RIGHT = (slice(0, 2), slice(0, 1)), (slice(1, 2), slice(2, 3))


def test_a_copy_of_a_read_only_costmap_keeps_the_windows_of_all_copies_between() -> None:
    base = grids.costmap("""
        ...
        ...
    """).read_only()
    left = base.copied(LEFT)
    left.data[LEFT] = 254
    both = left.copied(RIGHT)
    both.data[RIGHT] = 254
    assert both.changes is not None
    assert both.changes.windows == (LEFT, RIGHT)
    assert grids.keeps_its_changes(both, base)
    assert grids.keeps_its_changes(left, base), "it is not written through its copy"
    both.data[0, 2] = 254
    assert not grids.keeps_its_changes(both, base)


def test_of_a_costmap_that_others_may_write_no_changes_are_kept() -> None:
    costmap = grids.costmap("...")
    copy = costmap.copied((slice(0, 1), slice(0, 1)))
    assert copy.changes is None
    copy.data[:] = 254
    assert not costmap.data.any()


def test_cells_of_another_shape_are_refused() -> None:
    with pytest.raises(InvalidMap, match="expected uint8 cells of shape"):
        Costmap(np.zeros((2, 2), np.uint8), GridInfo(1.0, 3, 2))


def costmap(data: object) -> Costmap:
    cells = np.array(data, np.uint8)
    height, width = cells.shape
    return Costmap(cells, GridInfo(0.05, width, height, Pose2D(-1.0, 2.0, 0.5)))


@pytest.mark.parametrize(
    ("cost", "occupancy"),
    [(0, 0), (1, 1), (2, 1), (3, 1), (4, 2), (128, 50), (251, 97), (252, 98), (253, 99), (254, 100), (255, -1)],
)
def test_costs_are_translated_as_by_costmap_2d(cost: int, occupancy: int) -> None:
    """Graded costs become 1 + 97 · (cost − 1) / 251 in whole numbers."""
    assert occupancy_of(costmap([[cost]])).data.tolist() == [[occupancy]]


def test_every_graded_cost_is_translated_as_by_costmap_2d() -> None:
    occupancy = occupancy_of(costmap([list(range(1, 253))])).data[0].tolist()
    assert occupancy == [1 + (97 * (cost - 1)) // 251 for cost in range(1, 253)]


def test_a_costmap_keeps_its_geometry() -> None:
    made = costmap([[0, 253, 255], [254, 1, 0]])
    assert occupancy_of(made).info == made.info


def test_a_large_costmap_becomes_coarser_by_its_highest_cost() -> None:
    made = costmap([[0, 1, 255, 255, 0], [254, 0, 255, 255, 255], [255, 0, 252, 253, 0]])
    coarse = occupancy_of(made, most=6)
    assert coarse.data.tolist() == [[100, -1, 0], [0, 99, 0]]
    assert coarse.info == GridInfo(0.1, 3, 2, made.info.origin)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(1, 100))
def test_no_cell_is_lost_and_no_grid_is_larger_than_allowed(height: int, width: int, most: int) -> None:
    cells = np.zeros((height, width), np.uint8)
    cells[-1, -1] = 254
    coarse = occupancy_of(costmap(cells), most)
    assert coarse.data.size <= most
    factor = coarse.info.resolution / 0.05
    assert coarse.info.width * factor >= width and coarse.info.height * factor >= height
    assert coarse.data[-1, -1] == 100


def test_the_largest_grid_has_at_most_four_mebibytes_as_json() -> None:
    cells = np.full((1100, 1000), 254, np.uint8)
    message = to_message(occupancy_of(costmap(cells)))
    assert message.info.width * message.info.height <= MAX_CELLS
    assert len(bytes(message.data)) <= 4 << 20
