"""Presence of robots: their sockets, and the counts of containers that stand in while an endpoint has not reported."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from engine.links.place_link import PlaceLink
from engine.links.presence import MOST_GONE, Presence, RobotPresence
from engine.protocols import robot_link
from ppaas.clock import ManualClock
from tests.support.endpoints.still_place import StillStream

KEY = "robot:ann/tb1"


def world() -> tuple[RobotPresence, dict[str, PlaceLink], ManualClock]:
    places: dict[str, PlaceLink] = {}
    clock = ManualClock(1000.0)
    return RobotPresence(places.get, clock), places, clock


def with_container(*, robot: bool) -> PlaceLink:
    """Return a place whose container has said hello."""
    place = PlaceLink(KEY)
    hello = robot_link.Hello("c1", "", 7, 0, [], [], [], beat=beat(robot=robot))
    place.begin(hello, StillStream())
    return place


def beat(*, robot: bool) -> robot_link.ContainerBeat:
    return robot_link.ContainerBeat(busy=False, sockets=1, robot=robot)


def test_a_robot_is_connected_while_its_socket_is_here() -> None:
    presence, _, clock = world()
    assert presence.of(KEY) == Presence(False, None)
    presence.came(KEY)
    assert presence.of(KEY) == Presence(True)
    clock.advance(5.0)
    presence.left(KEY)
    assert presence.of(KEY) == Presence(False, 1005.0)
    presence.came(KEY)
    assert presence.of(KEY) == Presence(True)


def test_robots_that_left_and_are_not_back_are_counted() -> None:
    presence, _, clock = world()
    for robot in ("early", "late", "back"):
        presence.left(robot)
        clock.advance(10.0)
    presence.came("back")
    assert [presence.gone_since(time) for time in (999.0, 1000.0, 1010.0)] == [2, 1, 0]


def test_the_container_does_not_make_a_robot_connected() -> None:
    presence, places, _ = world()
    places[KEY] = with_container(robot=True)
    assert not presence.is_here(KEY)
    presence.came(KEY)
    presence.left(KEY)
    assert not presence.is_here(KEY)


def test_the_count_of_an_adopted_container_stands_in_until_endpoints_have_reported() -> None:
    presence, places, clock = world()
    presence.expect(KEY)
    assert not presence.is_here(KEY)
    places[KEY] = with_container(robot=True)
    assert presence.is_here(KEY)
    assert not presence.has_socket(KEY)
    places[KEY].take(beat(robot=False))
    assert not presence.is_here(KEY)
    places[KEY].take(beat(robot=True))
    presence.came(KEY)
    presence.left(KEY)
    assert presence.of(KEY) == Presence(False, clock())


def test_an_adopted_robot_that_no_endpoint_reports_is_gone() -> None:
    presence, places, clock = world()
    places[KEY] = with_container(robot=True)
    presence.expect(KEY)
    clock.advance(30.0)
    presence.give_up(KEY)
    assert presence.of(KEY) == Presence(False, 1030.0)
    presence.came(KEY)
    presence.give_up(KEY)
    assert presence.is_here(KEY)


def test_times_of_robots_that_left_are_bounded() -> None:
    presence, _, _ = world()
    for number in range(MOST_GONE + 1):
        presence.left(str(number))
    assert presence.of("0") == Presence(False, None)
    assert presence.of(str(MOST_GONE)).disconnected_since is not None


@given(st.lists(st.sampled_from(["came", "left", "expect", "give_up"])))
def test_without_a_container_the_last_report_of_an_endpoint_decides(events: list[str]) -> None:
    presence, _, _ = world()
    for event in events:
        deed: Any = getattr(presence, event)
        deed(KEY)
    reports = [event for event in events if event in ("came", "left")]
    assert presence.is_here(KEY) == (reports[-1:] == ["came"])
    assert not (presence.is_here(KEY) and presence.of(KEY).disconnected_since)
