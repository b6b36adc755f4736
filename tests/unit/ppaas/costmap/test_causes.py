"""Causes of lethal places, by their names."""

from pathlib import Path

import numpy as np
import pytest

from engine.specs.layer_files import open_layers, write_layers
from ppaas.costmap.build_layers import build_layers, recosted, with_closed
from ppaas.costmap.causes import Body, Cause, Causes, barriers_at
from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import GoalOccupied, StartOccupied
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.registry import create as create_planner
from ppaas.zones.schedule import Hours
from ppaas.zones.zone import KeepOut, ZoneSet
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

SPILL = rectangle(KeepOut(name="spill"), 2.0, 2.0, 3.0, 3.0)
NIGHT = rectangle(KeepOut(name="night", times=[Hours(begin="22:00")]), 5.0, 5.0, 6.0, 6.0)
ZONES = ZoneSet([SPILL, NIGHT])


@pytest.fixture(scope="module")
def layers() -> MapLayers:
    """Return the layers of a room of 8 × 8 m with a wall, a zone, a mask, and a zone at night."""
    info = GridInfo(0.1, 80, 80)
    mask = np.zeros(info.shape, np.int8)
    mask[60:70, 10:20] = OCCUPIED
    return build_layers(walled_map(8, 8, [(4.0, 0.0, 4.2, 4.0)]), zones=ZONES, keepout=GridMap(mask, info))


def kind_at(layers: MapLayers, x: float, y: float) -> tuple[str, str]:
    assert layers.costmap.causes is not None
    cause = layers.costmap.causes(x, y)
    assert cause is not None
    return cause.kind, cause.name


def test_map_zones_and_masks_are_told_apart(layers: MapLayers) -> None:
    assert kind_at(layers, 4.1, 1.0) == ("map", "")
    assert kind_at(layers, 2.5, 2.5) == ("zone", "spill")
    assert kind_at(layers, 2.5, 3.1) == ("zone", "spill")
    assert kind_at(layers, 1.5, 6.5) == ("mask", "")
    assert kind_at(layers, 5.5, 5.5) != ("zone", "night"), "it is not in force"


def test_a_zone_that_is_in_force_is_named(layers: MapLayers) -> None:
    closed = with_closed(layers, [NIGHT], 0.2, CostParameters())
    assert kind_at(closed, 5.5, 5.5) == ("zone", "night")
    assert kind_at(closed, 2.5, 2.5) == ("zone", "spill")


@pytest.fixture(scope="module")
def shelf() -> MapLayers:
    """Return the layers of a room with a zone, a mask, and a shelf of an octomap between the two and in the zone."""
    info = GridInfo(0.1, 80, 80)
    mask, overhead = np.zeros(info.shape, np.int8), np.zeros(info.shape, np.int8)
    mask[60:70, 10:20] = OCCUPIED
    overhead[45:50, 10:20] = overhead[22:25, 22:25] = OCCUPIED
    return build_layers(
        walled_map(8, 8, []), zones=ZONES, keepout=GridMap(mask, info), overhead=GridMap(overhead, info)
    )


def test_an_octomap_is_told_from_masks_and_zones(shelf: MapLayers, tmp_path: Path) -> None:
    write_layers(tmp_path, shelf, created=0.0)
    for layers in (shelf, open_layers(tmp_path), with_closed(shelf, [NIGHT], 0.2, CostParameters())):
        assert kind_at(layers, 1.5, 4.7) == ("octomap", "")
        assert kind_at(layers, 1.5, 5.2) == ("octomap", "")
        assert kind_at(layers, 1.5, 6.5) == ("mask", "")
        assert kind_at(layers, 2.35, 2.35) == ("zone", "spill")


def test_the_nearest_barrier_counts_although_a_zone_is_farther_off(shelf: MapLayers) -> None:
    assert kind_at(shelf, 2.0, 4.5) == ("octomap", "")
    nearest = [(cause.kind, cause.name) for cause in barriers_at(shelf, 1.9, 4.5, 3.0)]
    assert nearest == [("octomap", ""), ("zone", "spill"), ("mask", "")]


def test_a_refused_goal_names_the_octomap(shelf: MapLayers) -> None:
    with pytest.raises(GoalOccupied, match=r"the goal .* is in an obstacle of the octomap at the height of the robot"):
        create_planner("dijkstra").plan(shelf.costmap, PlanRequest(Pose2D(6.5, 6.5), Pose2D(1.5, 4.7)))


def test_a_costmap_without_masks_names_none(layers: MapLayers) -> None:
    bare = recosted(layers, 0.2, CostParameters())
    assert bare.causes is not None
    found = bare.causes(2.5, 2.5)
    assert found is None or found.kind == "map"


def test_robots_and_people_count_before_what_the_laser_sees_of_them(layers: MapLayers) -> None:
    bodies = (Body("robot", 6.0, 2.0, 0.3, "tb2"), Body("robot", 7.0, 6.0, 0.3), Body("person", 6.0, 3.5, 0.3))
    seen = np.array(((6.0, 2.2), (6.0, 3.3), (7.0, 3.0)))
    causes = Causes(layers, bodies, seen)
    found = [causes(x, y) for x, y in ((6.0, 2.1), (7.0, 6.1), (6.0, 3.4), (7.0, 3.05))]
    assert [cause and cause.text for cause in found] == [
        "robot tb2", "another robot", "a person", "an obstacle that the sensors see"
    ]  # fmt: skip


def test_a_place_far_from_everything_or_off_the_map_has_no_cause() -> None:
    layers = build_layers(GridMap(np.zeros((20, 20), np.int8), GridInfo(0.1, 20, 20)))
    causes = Causes(layers)
    assert causes(1.0, 1.0) is None
    assert causes(-5.0, 1.0) is None
    assert Causes(layers, [Body("robot", 1.2, 1.0, 0.1, "a")])(1.0, 1.0) == Cause("robot", "a", pytest.approx(0.1))


@pytest.mark.parametrize("planner", ["dijkstra", "astar", "theta_star", "lattice", "dstar_lite", "navfn", "jps"])
def test_planners_name_the_zone_of_a_start_and_of_a_goal(layers: MapLayers, planner: str) -> None:
    inside, outside = Pose2D(2.5, 2.5), Pose2D(1.0, 1.0)
    for start, goal, error, word in (
        (inside, outside, StartOccupied, "start"),
        (outside, inside, GoalOccupied, "goal"),
    ):
        with pytest.raises(error) as caught:
            create_planner(planner).plan(layers.costmap, PlanRequest(start, goal))
        assert f"the {word} x=2.500 y=2.500 is in the keep-out zone 'spill'" in str(caught.value)
        assert f"choose a {word} outside of it, or change the zones of the map" in str(caught.value)
