"""Speed limits of zones, by place and time."""

from datetime import UTC, datetime

import pytest

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.geometry import Pose2D
from ppaas.nodes.move_base.speed_limits import ZoneSpeeds
from ppaas.zones.schedule import Hours
from ppaas.zones.zone import KeepOut, SpeedZone, ZoneSet
from tests.support.zones import rectangle

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
