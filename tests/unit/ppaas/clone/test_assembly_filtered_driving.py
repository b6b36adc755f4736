"""A clone with masks: it keeps out of some places, and drives slowly in others."""

import math
from itertools import pairwise

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import nav2_msgs
from ppaas.messages.actionlib_msgs import Status
from ppaas.zones.zone import KeepOut, ZoneSet
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import Box, World, fill, walled_map
from tests.support.zones import rectangle

RADIUS = 0.18
START, BEYOND = Pose2D(1.0, 1.0, math.pi / 2), Pose2D(6.5, 1.6, 0.0)

# A wall across the room with two doors: y from 1 to 2.2 m, and from 5.8 to 7 m.
TWO_DOORS = [(3.9, 0.0, 4.1, 1.0), (3.9, 2.2, 4.1, 5.8), (3.9, 7.0, 4.1, 8.0)]
NEAR_DOOR, FAR_DOOR = (3.5, 0.5, 4.5, 2.7), (3.5, 5.5, 4.5, 7.5)
SLOW = (2.5, 0.0, 5.5, 8.0)


def mask(*boxes: Box) -> GridMap:
    """Return a mask with cells of 0.1 m, 100 in the boxes, with an origin of its own."""
    info = GridInfo(0.1, 100, 100, Pose2D(-1.0, -1.0))
    data = np.zeros(info.shape, np.int8)
    for box in boxes:
        fill(data, info, box)
    return GridMap(data, info)


def driven(goal: Pose2D = BEYOND, start: Pose2D = START, limit: float = 0.0, **options) -> ClosedLoop:
    """Return the loop after a goal."""
    driving = ClosedLoop(World(walled_map(8, 8, TWO_DOORS), start), **options)
    for _ in range(6):
        driving.step()
    driving.graph.inject("speed_limit", nav2_msgs.SpeedLimit(limit))
    driving.send_goal(goal)
    driving.track = []
    while not driving.results and len(driving.track) < 1600:
        driving.step()
        driving.track.append((driving.world.pose, driving.command.linear.x))
    return driving


KEEPOUT = {"keepout_filter": {"filter_mask": "kept"}}


def distance_to(box: Box, pose: Pose2D) -> float:
    return math.hypot(max(box[0] - pose.x, 0.0, pose.x - box[2]), max(box[1] - pose.y, 0.0, pose.y - box[3]))


@pytest.mark.parametrize("planner", ["dwa", "mppi"])
def test_robot_stays_out_of_keepout_zones(planner):
    driving = driven(base_local_planner=planner, masks={"keepout": mask(NEAR_DOOR)}, parameters=KEEPOUT)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert min(distance_to(NEAR_DOOR, pose) for pose, _ in driving.track) > RADIUS
    assert driving.clearance > RADIUS


def test_goal_is_aborted_at_once_if_keepout_zones_block_all_paths():
    driving = driven(masks={"keepout": mask(NEAR_DOOR, FAR_DOOR)}, parameters=KEEPOUT)
    assert driving.last_status() is Status.ABORTED
    assert len(driving.track) < 20
    assert "no free path" in driving.results[-1].status.text


def test_goal_in_a_keepout_zone_is_refused_and_one_beside_is_reached():
    refused = driven(Pose2D(3.0, 1.6), masks={"keepout": mask((2.5, 1.0, 3.5, 2.2))}, parameters=KEEPOUT)
    assert refused.last_status() is Status.ABORTED
    beside = driven(Pose2D(3.0, 2.6), masks={"keepout": mask((2.5, 1.0, 3.5, 2.2))}, parameters=KEEPOUT)
    assert beside.last_status() is Status.SUCCEEDED


@pytest.mark.parametrize("planner", ["dwa", "mppi", "pure_pursuit"])
def test_robot_obeys_the_speed_mask(planner):
    parameters = {"speed_filter": {"filter_mask": "slow", "type": 2, "base": 0.25, "multiplier": -0.001}}
    driving = driven(base_local_planner=planner, masks={"speed": mask(SLOW)}, parameters=parameters)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    # The pose estimate is good to a few centimetres, and the robot brakes no faster than its limit.
    inside = [speed for pose, speed in driving.track if SLOW[0] + 0.4 < pose.x < SLOW[2] - 0.2]
    outside = [speed for pose, speed in driving.track if not SLOW[0] < pose.x < SLOW[2]]
    assert max(inside) == pytest.approx(0.15, abs=0.005)
    assert max(outside) > 0.35


def test_lower_limit_of_speed_mask_and_operator_applies():
    parameters = {"speed_filter": {"filter_mask": "slow", "base": 100.0, "multiplier": -0.7}}
    driving = driven(Pose2D(3.0, 1.6), limit=0.3, masks={"speed": mask(SLOW)}, parameters=parameters)
    inside = [speed for pose, speed in driving.track if pose.x > SLOW[0] + 0.3]
    outside = [speed for pose, speed in driving.track if pose.x < SLOW[0]]
    assert max(inside) == pytest.approx(0.3 * 0.65, abs=0.005)
    assert max(outside) == pytest.approx(0.3, abs=0.005)


@pytest.mark.parametrize("name", ["keepout_filter", "speed_filter"])
def test_missing_mask_is_an_error_unless_its_filter_is_disabled(name):
    with pytest.raises(Unavailable, match="'kept' was not loaded"):
        driven(parameters={name: {"filter_mask": "kept"}})
    off = driven(Pose2D(1.0, 1.4), parameters={name: {"filter_mask": "kept", "enabled": False}})
    assert off.last_status() is Status.SUCCEEDED


def test_speed_mask_with_invalid_limits_is_an_error():
    with pytest.raises(InvalidParameter, match="cells with value 100 in mask 'slow' give a limit of 0 %"):
        driven(
            masks={"speed": mask(SLOW)},
            parameters={"speed_filter": {"filter_mask": "slow", "base": 100.0, "multiplier": -1.0}},
        )


@pytest.mark.parametrize("planner", ["dwa", "mppi", "pure_pursuit"])
def test_robot_that_starts_in_a_keepout_zone_leaves_it_by_the_shortest_way_and_stays_out(planner):
    zone = (0.3, 0.3, 2.0, 3.0)
    driving = driven(base_local_planner=planner, masks={"keepout": mask(zone)}, parameters=KEEPOUT)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    apart = [distance_to(zone, pose) for pose, _ in driving.track]
    left = next(number for number, distance in enumerate(apart) if distance > RADIUS)
    assert min(apart[left:]) > RADIUS - 0.02, "it is not led in again"
    driven_in_zone = sum(one.distance_to(other) for (one, _), (other, _) in pairwise(driving.track[:left]))
    assert driven_in_zone < 1.0 + RADIUS + 0.4, "the nearest side is 1 m away"


def test_robot_in_a_keepout_zone_does_not_drive_to_a_goal_in_it():
    driving = driven(Pose2D(1.4, 2.0), masks={"keepout": mask((0.3, 0.3, 2.0, 3.0))}, parameters=KEEPOUT)
    assert driving.last_status() is Status.ABORTED
    assert "the goal x=1.400 y=2.000 is in a keep-out mask" in driving.results[-1].status.text
    assert driving.world.pose.distance_to(START) < 0.05


def test_robot_leaves_a_zone_that_comes_over_it_while_it_drives():
    driving = ClosedLoop(World(walled_map(8, 8, TWO_DOORS), START))
    for _ in range(6):
        driving.step()
    driving.send_goal(BEYOND)
    for _ in range(60):
        driving.step()
    here = driving.world.pose
    zone = rectangle(KeepOut(name="spill"), here.x - 0.6, here.y - 0.6, here.x + 0.6, here.y + 0.6)
    layers = build_layers(driving.world.grid, robot_radius=RADIUS, zones=ZoneSet([zone]))
    driving.graph.nodes["move_base"].use_layers(layers)
    driving.run(60.0)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text


@pytest.mark.parametrize("outside", [False, True])
def test_a_refused_goal_names_the_zone(outside):
    zone = rectangle(KeepOut(name="spill"), 2.5, 1.0, 3.5, 2.2)
    driving = driven(Pose2D(2.4 if outside else 3.0, 1.6), masks={"zones": ZoneSet([zone])})
    assert driving.last_status() is Status.ABORTED
    where = "is too close to" if outside else "is in"
    assert f"{where} the keep-out zone 'spill'" in driving.results[-1].status.text
    assert "choose a goal outside of it, or change the zones" in driving.results[-1].status.text
