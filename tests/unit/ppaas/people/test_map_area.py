import numpy as np
import pytest

from ppaas.costmap.costmap import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.people.coordinator.visibility import MapArea


def test_the_distance_is_that_from_known_free_cells_also_outside_the_map() -> None:
    data = np.full((20, 30), NO_INFORMATION, np.uint8)
    data[5:15, 5:15] = FREE_SPACE
    data[5:15, 14] = LETHAL_OBSTACLE
    area = MapArea(Costmap(data, GridInfo(0.1, 30, 20, Pose2D(1.0, 2.0))))
    points = np.array([[1.95, 3.05], [2.85, 3.05], [6.0, 3.05], [1.95, 0.0]])
    # In it; 5 cells behind the wall; beyond the right edge; below the lower edge.
    assert area.distance(points) == pytest.approx([0.0, 0.5, 3.7, 2.5], abs=0.11)


def test_a_map_without_free_cells_has_nobody() -> None:
    area = MapArea(Costmap(np.full((4, 5), NO_INFORMATION, np.uint8), GridInfo(0.1, 5, 4)))
    assert area.distance(np.array([[0.2, 0.2]]))[0] > 0.5
