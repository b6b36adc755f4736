"""Layers by which a robot leaves the zones and masks that came over it."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.leaving import EXPENSIVE, Leaving
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.zones.schedule import Hours
from ppaas.zones.zone import KeepOut, Zone, ZoneSet
from tests.support.zones import rectangle

RADIUS = 0.2
INFO = GridInfo(0.05, 120, 120, Pose2D(-1.0, -1.0, 0.3))
SPILL = rectangle(KeepOut(name="spill"), 0.0, 1.0, 1.0, 2.0)
STAIRS = rectangle(KeepOut(name="stairs"), 0.5, 1.5, 2.0, 3.0)
AT_NIGHT = rectangle(KeepOut(name="night", times=[Hours(begin="22:00", end="06:00")]), 0.0, 1.0, 1.0, 2.0)
IN_SPILL, IN_BOTH, FREE = Pose2D(0.2, 1.2, 0.0), Pose2D(0.75, 1.75, 0.0), Pose2D(0.5, 0.2, 0.0)


def layers_with(*zones: Zone, **masks: GridMap) -> MapLayers:
    grid = GridMap(np.zeros(INFO.shape, np.int8), INFO)
    return build_layers(grid, robot_radius=RADIUS, zones=ZoneSet(list(zones)), **masks)  # type: ignore[arg-type]


def value_at(layers: MapLayers, pose: Pose2D) -> int:
    assert layers.keepout is not None
    return int(layers.keepout.data[INFO.cell_of(pose.x, pose.y)])


def test_a_robot_outside_of_all_zones_uses_the_layers_of_the_map() -> None:
    layers = layers_with(SPILL)
    leaving = Leaving(layers, RADIUS)
    assert not leaving.look(FREE)
    assert leaving.layers is layers
    assert not leaving.active


def test_the_zone_around_a_robot_is_expensive_and_others_stay_lethal() -> None:
    leaving = Leaving(layers_with(SPILL, STAIRS), RADIUS)
    assert leaving.look(IN_SPILL)
    assert value_at(leaving.layers, IN_SPILL) == EXPENSIVE
    assert value_at(leaving.layers, Pose2D(1.5, 2.5)) == OCCUPIED
    assert value_at(leaving.layers, IN_BOTH) == OCCUPIED, "it is also in a zone that the robot is not in"
    assert not leaving.look(Pose2D(0.25, 1.2)), "the layers stay the same in the zone"


def test_all_zones_around_a_robot_are_expensive() -> None:
    leaving = Leaving(layers_with(SPILL, STAIRS), RADIUS)
    leaving.look(IN_BOTH)
    assert [value_at(leaving.layers, pose) for pose in (IN_BOTH, IN_SPILL)] == [EXPENSIVE, EXPENSIVE]


def test_a_zone_is_lethal_again_once_no_part_of_the_robot_is_in_it() -> None:
    layers = layers_with(SPILL)
    leaving = Leaving(layers, RADIUS)
    leaving.look(IN_SPILL)
    assert not leaving.look(Pose2D(0.5, 1.0 - 0.7 * RADIUS)), "its edge is still in the zone"
    assert leaving.look(Pose2D(0.5, 1.0 - 1.3 * RADIUS))
    assert leaving.layers is layers
    assert not leaving.look(Pose2D(0.5, 1.0 - 0.9 * RADIUS)), "a robot that drives by a zone does not enter it"
    assert not leaving.active


def test_masks_are_opened_without_the_zones_beside_them() -> None:
    data = np.zeros(INFO.shape, np.int8)
    data[:, :] = OCCUPIED
    leaving = Leaving(layers_with(SPILL, keepout=GridMap(data, INFO)), RADIUS)
    leaving.look(FREE)
    assert [value_at(leaving.layers, pose) for pose in (FREE, IN_SPILL)] == [EXPENSIVE, OCCUPIED]


def test_a_zone_with_times_counts_only_where_the_layers_bar_it() -> None:
    leaving = Leaving(layers_with(AT_NIGHT, STAIRS), RADIUS)
    assert not leaving.look(IN_SPILL)


def test_an_outline_is_in_a_zone_where_it_overlaps_it() -> None:
    hull = np.array(((0.5, 0.1), (-0.5, 0.1), (-0.5, -0.1), (0.5, -0.1)))
    layers = layers_with(SPILL)
    beside, across = Pose2D(0.5, 0.8, 0.0), Pose2D(0.5, 0.8, math.pi / 2)
    assert [Leaving(layers, RADIUS, hull).look(pose) for pose in (beside, across)] == [False, True]


@pytest.mark.parametrize("pose", [Pose2D(-30.0, 5.0), Pose2D(90.0, -4.0)])
def test_a_robot_off_the_map_is_in_no_zone(pose: Pose2D) -> None:
    assert not Leaving(layers_with(SPILL), RADIUS).look(pose)


def test_the_window_of_a_robot_in_a_zone_lets_it_out_and_bars_the_others() -> None:
    local = LocalCostmap(layers_with(SPILL, STAIRS), robot_radius=RADIUS)
    costs = local.update(IN_SPILL)
    cost = {pose: int(costs.data[costs.info.cell_of(pose.x, pose.y)]) for pose in (IN_SPILL, IN_BOTH, FREE)}
    assert (cost[IN_SPILL], cost[IN_BOTH], cost[FREE]) == (251, 254, 0)
    assert local.way_out is not None
    assert local.way_out.data[INFO.cell_of(*IN_SPILL[:2])] == 251
    costs = local.update(FREE)
    assert costs.data[costs.info.cell_of(*IN_SPILL[:2])] == 254
    assert local.way_out is None
