"""Chargers and batteries in a simulated world."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Zone, ZoneSet
from robots.sim.docks.fitting import RobotBattery, fit_chargers
from robots.sim.world import World
from tests.support.world.rooms import room

ZONES = ZoneSet(
    [
        Zone(Point([4.0, 3.0]), Dock(name="charger", yaw=0.0)),
        Zone(Point([1.0, 3.0]), Dock(name="cart", yaw=0.0, charges=False)),
    ]
)


def test_a_charger_stands_at_each_dock_that_charges() -> None:
    world = World(room(6.0, 6.0))
    chargers = fit_chargers(world, ZONES)
    assert [charger.docked for charger in chargers] == [Pose2D(4.0, 3.0, 0.0)]
    assert len(world.furniture) == 1


@pytest.mark.parametrize(("x", "rises"), [(4.0, True), (2.0, False)])
def test_a_battery_follows_the_robot(x: float, rises: bool) -> None:
    world = World(room(6.0, 6.0))
    battery = RobotBattery(world.add_robot(Pose2D(x, 3.0)), fit_chargers(world, ZONES), charge=0.4)
    for _ in range(50):
        world.step()
        battery.after_step(world.dt)
    assert (battery.charge > 0.4) is rises
