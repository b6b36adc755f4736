"""Zones of an AGV, led by its master control."""

from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.master.instructions import Complaint, SendActions, SendZones
from ppaas.wire.vda5050.master.zone_control import PATIENCE, ZoneControl, zone_set_of
from ppaas.wire.vda5050.zones import Zone, Zones, ZoneSet
from tests.support.vda5050.simple_agv import SimpleAgv

CORNERS = [Point(x=0.0, y=0.0), Point(x=1.0, y=0.0), Point(x=1.0, y=1.0)]


def zones(*names: str) -> Zones:
    return zone_set_of("hall", [Zone(zone_id=name, zone_type="BLOCKED", vertices=CORNERS) for name in names])


class Led:
    """Zone control with its AGV, whose messages arrive at once unless they are lost."""

    def __init__(self) -> None:
        self.control, self.agv = ZoneControl(), SimpleAgv()
        self.now, self.lost = 1000.0, False
        self.told: list[str] = []

    def run(self, states: int = 10, period: float = 1.0) -> None:
        """Let the AGV say its state some times."""
        for _ in range(states):
            self.now += period
            for each in self.control.advance(self.agv.state(), self.now):
                match each:
                    case SendZones():
                        self.told.append(f"take {each.zones.zone_set.zone_set_id}")
                        if not self.lost:
                            self.agv.take_zones(each.zones)
                    case SendActions():
                        action = each.actions.actions[0]
                        self.told.append(f"{action.action_type} {action.parameter('zoneSetId')}")
                        if not self.lost:
                            self.agv.take_actions(each.actions)
                    case Complaint():
                        self.told.append(each.text)


def test_ids_are_those_of_the_zones_and_the_map() -> None:
    assert zones("a").zone_set_id == zones("a").zone_set_id != zones("b").zone_set_id
    assert zone_set_of("yard", zones("a").zones).zone_set_id != zones("a").zone_set_id
    assert len(zones("a").zone_set_id) == 22


def test_a_set_is_sent_and_enabled_once() -> None:
    led, wanted = Led(), zones("a")
    led.run()
    assert led.told == []
    led.control.want(wanted)
    led.run()
    assert led.told == [f"take {wanted.zone_set_id}", f"enableZoneSet {wanted.zone_set_id}"]
    assert led.agv.zone_sets == {wanted.zone_set_id: wanted}
    assert led.agv.enabled_zones == wanted.zone_set_id


def test_the_set_before_is_deleted_once_another_is_in_use() -> None:
    led, first, second = Led(), zones("a"), zones("a", "b")
    led.control.want(first)
    led.run()
    led.control.want(second)
    led.run()
    key = second.zone_set_id
    assert led.told[2:] == [f"take {key}", f"enableZoneSet {key}", f"deleteZoneSet {first.zone_set_id}"]
    assert list(led.agv.zone_sets) == [key]


def test_zones_end_by_an_empty_set_and_none_is_sent_without_need() -> None:
    led = Led()
    led.control.want(zones())
    led.run()
    assert led.told == []
    led.control.want(zones("a"))
    led.run()
    led.control.want(zones())
    led.run()
    assert list(led.agv.zone_sets) == [led.agv.enabled_zones] == [zones().zone_set_id]


def test_sets_of_others_are_left_alone() -> None:
    led, other = Led(), Zones(map_id="hall", zone_set_id="plant-7", zones=[])
    led.agv.take_zones(ZoneSet(zone_set=other))
    led.control.want(zones("a"))
    led.run()
    assert set(led.agv.zone_sets) == {"plant-7", zones("a").zone_set_id}


def test_a_restarted_bridge_sends_nothing_again() -> None:
    led = Led()
    led.control.want(zones("a"))
    led.run()
    led.control = ZoneControl()
    led.control.want(zones("a"))
    led.told.clear()
    led.run()
    assert led.told == []


def test_a_lost_set_is_sent_again_a_few_times_and_after_a_reconnection() -> None:
    led, key = Led(), zones("a").zone_set_id
    led.lost = True
    led.control.want(zones("a"))
    led.run(100)
    assert led.told == [*[f"take {key}"] * 3, f"it does not take zone set {key!r}, told 3 times"]
    led.lost = False
    led.run()
    assert len(led.told) == 4
    led.control.begin_again()
    led.run(3, PATIENCE)
    assert led.agv.enabled_zones == key
