"""A copy of a costmap keeps where it may differ from the map."""

import numpy as np
import pytest

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidMap
from ppaas.maps.grid import GridInfo
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
