import math
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import nav2_msgs
from ppaas.nodes.map_server.costmap_filters import SpeedFilterParameters
from ppaas.nodes.move_base.speed_limits import SpeedFilter, ZoneSpeeds, limit_of, lower_of
from ppaas.zones.schedule import Hours
from ppaas.zones.zone import KeepOut, SpeedZone, ZoneSet
from tests.support.zones import rectangle

MAX_VEL_X = 0.5


@pytest.mark.parametrize(
    ("message", "fastest"),
    [
        (nav2_msgs.SpeedLimit(0.0), 0.5),
        (nav2_msgs.SpeedLimit(0.0, percentage=True), 0.5),
        (nav2_msgs.SpeedLimit(0.2), 0.2),
        (nav2_msgs.SpeedLimit(3.0), 0.5),
        (nav2_msgs.SpeedLimit(40.0, percentage=True), 0.2),
        (nav2_msgs.SpeedLimit(0.01), 0.05),
        (nav2_msgs.SpeedLimit(1.0, percentage=True), 0.05),
    ],
)
def test_limit_is_absolute_or_a_percentage_with_a_minimum(message, fastest):
    assert limit_of(message).of(MAX_VEL_X, 0.05) == pytest.approx(fastest)


@pytest.mark.parametrize(
    "message",
    [
        nav2_msgs.SpeedLimit(-0.1),
        nav2_msgs.SpeedLimit(math.nan),
        nav2_msgs.SpeedLimit(math.inf),
        nav2_msgs.SpeedLimit(101.0, percentage=True),
    ],
)
def test_invalid_limit_is_refused(message):
    with pytest.raises(InvalidInput, match="speed_limit"):
        limit_of(message)


# Limits by place.


def slow(values, **parameters) -> SpeedFilter:
    """Return the filter of a mask with one row of cells of 1 m, starting at (0, 0)."""
    mask = GridMap(np.array([values], np.int8), GridInfo(1.0, len(values), 1))
    return SpeedFilter(mask, SpeedFilterParameters(filter_mask="slow", **parameters))


def test_mask_cells_are_converted_like_in_nav2():
    found = slow([0, 30, 100, -1], type=1, base=100.0, multiplier=-0.5)
    fastest = [found.at(Pose2D(x, 0.5, 1.0)).of(MAX_VEL_X, 0.05) for x in (0.5, 1.5, 2.5, 3.5, 4.5, -0.5)]
    assert fastest == pytest.approx([0.5, 0.5 * 0.85, 0.5 * 0.5, 0.5, 0.5, 0.5])
    metres = slow([0, 30, 10], type=2, multiplier=0.01)
    assert [metres.at(Pose2D(x, 0.5)).speed for x in (0.5, 1.5, 2.5)] == [math.inf, 0.3, 0.1]


@given(st.integers(1, 100), st.sampled_from([1, 2]), st.floats(-50.0, 150.0), st.floats(-2.0, 2.0))
def test_mask_cell_is_a_valid_limit_or_refused(value, kind, base, multiplier):
    limit = base + multiplier * value
    if limit > 0.0 and (kind == 2 or limit <= 100.0):
        found = slow([value], type=kind, base=base, multiplier=multiplier).at(Pose2D(0.5, 0.5))
        assert found == pytest.approx(SpeedLimit(limit) if kind == 2 else SpeedLimit(part=limit / 100.0))
    else:
        with pytest.raises(InvalidParameter, match=f"cells with value {value} in mask 'slow'"):
            slow([value], type=kind, base=base, multiplier=multiplier)


def test_values_not_in_the_mask_are_not_validated():
    assert slow([0, -1, 40], type=1, base=50.0, multiplier=-1.0).at(Pose2D(2.5, 0.5)).part == 0.1


def test_lower_of_combines_absolute_and_relative_limits():
    both = lower_of(SpeedLimit(speed=0.3), SpeedLimit(part=0.5))
    assert both == SpeedLimit(0.3, 0.5)
    assert lower_of(both, NO_LIMIT) == lower_of(NO_LIMIT, both) == both
    assert lower_of(SpeedLimit(part=0.4), SpeedLimit(part=0.5)) == SpeedLimit(part=0.4)


SLOW = SpeedZone(name="slow", max_speed=0.3)
HALF = SpeedZone(name="half", percent=50.0, times=[Hours(since=datetime.fromtimestamp(100.0, UTC))])


@pytest.mark.parametrize(
    ("x", "y", "now", "limit"),
    [
        (0.5, 0.5, 0.0, SpeedLimit(speed=0.3)),
        (1.1, 0.5, 0.0, SpeedLimit(speed=0.3)),
        (1.3, 0.5, 0.0, NO_LIMIT),
        (1.15, 1.15, 0.0, NO_LIMIT),
        (2.5, 0.5, 0.0, NO_LIMIT),
        (2.5, 0.5, 100.0, SpeedLimit(part=0.5)),
        (0.5, 0.5, 100.0, SpeedLimit(speed=0.3)),
    ],
)
def test_the_limit_of_a_zone_holds_while_a_part_of_the_robot_is_in_it(
    x: float, y: float, now: float, limit: SpeedLimit
) -> None:
    zones = ZoneSet([rectangle(SLOW, 0.0, 0.0, 1.0, 1.0), rectangle(HALF, 2.0, 0.0, 3.0, 1.0)])
    speeds = ZoneSpeeds(zones, 0.2, lambda: now)
    assert speeds and speeds.at(Pose2D(x, y)) == limit


def test_limits_change_with_the_time_and_all_of_those_that_overlap_hold() -> None:
    zones = ZoneSet([rectangle(SLOW, 0.0, 0.0, 1.0, 1.0), rectangle(HALF, 0.0, 0.0, 1.0, 1.0)])
    clock = [0.0]
    speeds = ZoneSpeeds(zones, 0.2, lambda: clock[0])
    assert speeds.at(Pose2D(0.5, 0.5)) == SpeedLimit(speed=0.3)
    clock[0] = 101.0
    assert speeds.at(Pose2D(0.5, 0.5)) == SpeedLimit(speed=0.3, part=0.5)


def test_maps_without_speed_zones_have_no_limits() -> None:
    speeds = ZoneSpeeds(ZoneSet([rectangle(KeepOut(name="wall"), 0.0, 0.0, 1.0, 1.0)]), 0.2, lambda: 0.0)
    assert not speeds and speeds.at(Pose2D(0.5, 0.5)) == NO_LIMIT
