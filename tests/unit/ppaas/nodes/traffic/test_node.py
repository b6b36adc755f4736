"""The traffic node: reports in, grants and the state out, services of operators."""

from datetime import UTC, datetime

import pytest

from ppaas.clone.traffic import build_traffic
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, NotFound
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, RobotOfTraffic, TrafficGrants, TrafficReport, TrafficState
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleState, TrackedPerson
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.traffic.node import TrafficNode
from ppaas.zones.schedule import Hours
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Lane, NoStop, Zone, ZoneSet
from tests.support.world.closed_loop import ManualClock
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

SURE = [0.01, 0.0, 0.0, 0.01]
"""Covariance of a position [m²]."""


class Hall:
    """A traffic node, and robots that stand in a room of 6 m × 4 m."""

    def __init__(self) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.grants: dict[str, TrafficGrants] = {}
        self.states: list[TrafficState] = []
        build_traffic(self.graph, build_layers(walled_map(6, 4, []), robot_radius=0.18))
        self.graph.tap("traffic/grants", self._hear)
        self.graph.tap("traffic/state", self._hear)

    def _hear(self, _topic: str, message: Payload) -> None:
        match message:
            case TrafficGrants():
                self.grants[message.robot] = message
            case TrafficState():
                self.states.append(message)

    def report(self, robot: str, x: float, y: float, **fields: object) -> None:
        """Publish a report of a robot that knows the last grants."""
        grants = self.grants.get(robot)
        header = Header(stamp=Time.of(self.clock()), frame_id="map")
        epoch = 0 if grants is None else grants.epoch
        report = TrafficReport(header, robot, x, y, 0.0, 0.18, 0.6, 0.2, epoch=epoch, **fields)  # type: ignore[arg-type]
        self.graph.inject("traffic/report", report)

    def run(self, seconds: float) -> None:
        """Let time pass, in which two robots report, one of which has a goal."""
        for _ in range(round(seconds / 0.1)):
            self.clock.advance(0.1)
            goal = {"goal_id": "there", "goal": MapPoint(4.0, 2.0)}
            self.report("tb1", 1.0, 2.0, **goal)
            self.report("tb2", 5.0, 2.0)
            self.graph.run_due()

    def call(self, service: str, request: Empty | RobotOfTraffic) -> Payload:
        """Call a service, and return its answer."""
        answers: list[Payload] = []
        self.graph.call(service, request, answers.append)
        (answer,) = answers
        return answer


def test_robots_are_granted_cells_on_the_way_to_their_goals() -> None:
    hall = Hall()
    hall.run(3.0)
    grants = hall.grants["tb1"]
    assert (grants.goal_id, len(grants.way) > 1, grants.free) == ("there", True, False)
    assert grants.way[-1].x > 1.0
    assert not hall.grants["tb2"].goal_id


def test_the_state_tells_of_all_robots_once_a_second_also_of_one_that_is_led_to_a_cell() -> None:
    hall = Hall()
    hall.run(3.05)
    assert len(hall.states) == 3
    state = hall.states[-1]
    assert [(each.robot, each.state) for each in state.robots] == [("tb1", "driving"), ("tb2", "driving")]
    assert state.spacing == pytest.approx(0.56)
    assert hall.call("traffic/get_traffic", Empty()) == state


def test_an_operator_takes_a_robot_out_and_puts_it_back() -> None:
    hall = Hall()
    hall.run(2.0)
    assert hall.call("traffic/take_out", RobotOfTraffic("tb2")) == Empty()
    hall.run(1.0)
    assert hall.grants["tb2"].free
    hall.call("traffic/put_back", RobotOfTraffic("tb2"))
    hall.run(1.0)
    assert not hall.grants["tb2"].free
    assert isinstance(hall.call("traffic/take_out", RobotOfTraffic("tb9")), NotFound)


def test_a_robot_that_has_left_the_map_holds_nothing_and_may_return() -> None:
    hall = Hall()
    hall.run(2.0)
    assert hall.call("traffic/let_go", RobotOfTraffic("tb2")) == Empty()
    assert [each.robot for each in hall.call("traffic/get_traffic", Empty()).robots] == ["tb1"]  # type: ignore[union-attr]
    assert hall.call("traffic/let_go", RobotOfTraffic("tb2")) == Empty(), "also if nobody knows it"
    hall.run(2.0)
    assert [each.robot for each in hall.states[-1].robots] == ["tb1", "tb2"]


def test_a_report_that_is_not_valid_is_refused() -> None:
    hall = Hall()
    with pytest.raises(InvalidInput, match="tb1"):
        hall.report("tb1", float("nan"), 0.0)
    assert hall.call("traffic/get_traffic", Empty()).robots == []  # type: ignore[union-attr]


def test_the_next_node_takes_a_higher_epoch_than_the_checkpoint() -> None:
    before, after = Hall(), Hall()
    before.run(3.0)
    state = before.graph.nodes["traffic"].checkpoint()
    assert state is not None
    after.graph.nodes["traffic"].restore(state)
    after.clock.advance(10.0)
    after.run(3.0)
    assert after.grants["tb1"].epoch > before.grants["tb1"].epoch
    with pytest.raises(InvalidInput, match="checkpoint"):
        after.graph.nodes["traffic"].restore(b"x")


def test_it_goes_on_with_another_map() -> None:
    hall = Hall()
    hall.run(3.0)
    node = hall.graph.nodes["traffic"]
    node.use_layers(build_layers(walled_map(6, 4, [(2.0, 0.1, 3.0, 3.0)]), robot_radius=0.18))  # type: ignore[attr-defined]
    hall.run(2.0)
    assert hall.grants["tb1"].way


def test_zones_come_into_force_while_robots_drive() -> None:
    hall = Hall()
    hall.run(3.0)
    hours = Hours(since=datetime.fromtimestamp(1010.0, UTC))
    zone = rectangle(NoStop(name="crossing", times=[hours]), 3.7, 1.7, 4.3, 2.3)
    layers = build_layers(walled_map(6, 4, []), robot_radius=0.18, zones=ZoneSet([zone]))
    node = hall.graph.nodes["traffic"]
    assert isinstance(node, TrafficNode)
    before = hall.grants["tb1"].epoch
    node.use_layers(layers)
    hall.run(1.0)
    assert (hall.grants["tb1"].refused, hall.grants["tb1"].give_back) == ("", False)
    hall.run(8.0)
    assert "do not stop" in hall.grants["tb1"].refused
    assert hall.grants["tb1"].epoch == before, "nobody begins anew"


def test_robots_begin_anew_along_lanes_that_are_drawn() -> None:
    hall = Hall()
    hall.run(3.0)
    node = hall.graph.nodes["traffic"]
    assert isinstance(node, TrafficNode)
    before = hall.grants["tb1"]
    assert all(point.y != 2.05 for point in before.way)
    lanes = ZoneSet([Zone(LineString([[0.6, 2.05], [5.4, 2.05]]), Lane(name="main"))])
    node.use_layers(build_layers(walled_map(6, 4, []), robot_radius=0.18, zones=lanes))
    hall.run(3.0)
    way = hall.grants["tb1"].way
    assert way and all(point.y == pytest.approx(2.05) for point in way)


@pytest.mark.parametrize(("state", "waits"), [("seen", "a person"), ("predicted", "")])
def test_robots_wait_for_people_who_are_seen(state: str, waits: str) -> None:
    hall = Hall()
    for _ in range(40):
        person = TrackedPerson(1, Point(1.7, 2.0), Point(0.0, 0.0), SURE, state=state)
        hall.graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 1, [person]))
        hall.run(0.1)
    waiting = {robot.robot: robot.waits_for for robot in hall.states[-1].robots}
    assert waiting["tb1"] == waits


def test_people_at_no_place_are_refused() -> None:
    person = TrackedPerson(1, Point(float("nan"), 0.0), Point(0.0, 0.0), SURE)
    with pytest.raises(InvalidInput, match="not finite"):
        Hall().graph.inject("people_coordinator/state", PeopleState(Header(frame_id="map"), 1, [person]))
