"""Lanes of halls in benches: robots that keep right get from everywhere to everywhere."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.harness.halls import ASIDE, right_hand_lanes
from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.maps.generate import warehouse
from ppaas.traffic.settings import TrafficParameters


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
