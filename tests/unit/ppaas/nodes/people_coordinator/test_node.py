"""The node that coordinates the robots of a group: reports, states and services on a graph."""

from typing import Any

import msgspec
import pytest

from engine.control.group_places import PEOPLE_LINGER
from ppaas.clock import ManualClock
from ppaas.clone.people_coordination import build_coordinator
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, NotFound
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance
from ppaas.messages.people_coordination import (
    ConfigurePeopleRequest,
    GetPeopleCountsRequest,
    PeopleReport,
    PeopleState,
    SensorView,
)
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.nodes.base import Checkpoint, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Work
from ppaas.nodes.people_coordinator.node import FIRST, PERIOD, UNSAVED, PeopleCoordinatorNode
from ppaas.people.settings import PeopleSettings
from ppaas.people.tracks.assignment import solver
from tests.support.world.planar_world import walled_map
from tests.support.world.service_calls import call_service

START = 36_000.0
PERSON = (3.0, 2.0)
ROBOTS = {"tb1": Pose2D(1.0, 2.0, 0.0), "tb2": Pose2D(5.0, 2.0, 3.14159)}


@pytest.fixture(scope="module")
def layers() -> MapLayers:
    return build_layers(walled_map(6, 4, []))


class Group:
    """A coordinator on a graph, and robots that see one person at `PERSON`."""

    def __init__(self, layers: MapLayers, settings: PeopleSettings | None = None, start: float = START) -> None:
        self.clock = ManualClock(start)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        build_coordinator(self.graph, layers, settings or PeopleSettings())
        self.states: list[PeopleState] = []
        self.graph.tap("people_coordinator/state", lambda _, state: self.states.append(state))  # type: ignore[arg-type]

    def run(self, seconds: float) -> PeopleState:
        """Let the robots report five times a second; return the last state."""
        for _ in range(round(seconds / PERIOD)):
            for robot, pose in ROBOTS.items():
                self.graph.inject("people_tracker/report", report(robot, pose, self.clock()))
            self.clock.advance(PERIOD + 1e-6)
            self.graph.run_due()
        return self.states[-1]

    def call(self, service: str, request: Message | None = None) -> Any:
        return call_service(self.graph, f"people_coordinator/{service}", request or Empty())


def report(robot: str, pose: Pose2D, now: float) -> PeopleReport:
    header = Header(stamp=Time.of(now), frame_id="map")
    seen = pose.inverse() @ Pose2D(*PERSON, 0.0)
    person = PositionMeasurement(
        header, f"{robot}/7", "7", Point(seen.x, seen.y), covariance=[0.01, 0, 0, 0, 0.01] + [0.0] * 4
    )
    view = SensorView(0.0, 0.0, 0.0, 1.0, 0.45, 8.0)
    return PeopleReport(header, robot, PoseWithCovariance(Pose.of(pose)), [person], [view], can_follow=True)


def test_the_first_state_does_not_wait_for_scipy(layers: MapLayers) -> None:
    jobs: list[Work[object]] = []
    clock = ManualClock(START)
    graph = Graph(lambda work, _cancelled, _done: jobs.append(work), clock=clock, stamp_clock=clock)
    states: list[Payload] = []
    build_coordinator(graph, layers, PeopleSettings())
    graph.tap("people_coordinator/state", lambda _, state: states.append(state))
    clock.advance(FIRST + 1e-6)
    graph.run_due()
    assert len(states) == len(jobs) == 1
    assert jobs[0](lambda: False) is solver()


def test_two_robots_that_see_a_person_have_one_identity_in_a_state_five_times_a_second(layers: MapLayers) -> None:
    group = Group(layers)
    state = group.run(2.0)
    assert len(group.states) == 11, "the first at once"
    (person,) = state.people
    assert state.count == 1 and sorted(person.seen_by) == ["tb1/7", "tb2/7"]
    assert (person.position.x, person.position.y) == pytest.approx(PERSON, abs=0.1)
    assert state.rule == "nearest" and len(state.orders) == 1
    assert group.call("get_people") == state == decode(PeopleState, encode(state))


def test_identities_go_on_from_a_checkpoint_and_so_does_their_number(layers: MapLayers) -> None:
    group = Group(layers)
    group.run(2.0)
    (checkpoint,) = group.graph.checkpoints()
    (before,) = group.states[-1].people
    other = Group(layers, start=group.clock())
    other.graph.restore([checkpoint])
    (after,) = other.run(1.0).people
    assert (after.id, after.first_seen) == (before.id, before.first_seen)
    assert msgspec.msgpack.decode(other.graph.checkpoints()[0].state)["next_id"] == before.id + 1 + UNSAVED
    with pytest.raises(InvalidInput, match="people coordinator"):
        Group(layers).graph.restore([Checkpoint("people_coordinator", b"of another release")])


def test_settings_change_while_it_runs_and_wrong_ones_change_nothing(layers: MapLayers) -> None:
    group = Group(layers)
    group.run(1.0)
    settings = PeopleSettings(rule="longest_seen", followed_at_once=0)
    group.call("configure_people", ConfigurePeopleRequest(msgspec.json.encode(settings).decode()))
    assert (group.run(1.0).rule, group.states[-1].orders) == ("longest_seen", [])
    for text, error in (('{"rule": "guess"}', NotFound), ("{", InvalidInput), ('{"followed": 1}', InvalidInput)):
        with pytest.raises(error):
            group.call("configure_people", ConfigurePeopleRequest(text))
    assert group.run(0.4).rule == "longest_seen"
    with pytest.raises(NotFound, match="guess"):
        Group(layers, PeopleSettings(rule="guess"))


def test_people_are_counted_by_hour_with_history_alone(layers: MapLayers) -> None:
    plain, counting = Group(layers), Group(layers, PeopleSettings(history=True))
    for group in (plain, counting):
        group.run(3.0)
    assert plain.call("get_people_counts", GetPeopleCountsRequest(0)).counts == []
    (row,) = counting.call("get_people_counts", GetPeopleCountsRequest(0)).counts
    assert (row.zone, row.hour, row.people) == ("", 36_000, 1)


def test_a_report_that_is_not_finite_is_refused_and_harmless(layers: MapLayers) -> None:
    group = Group(layers)
    before = group.run(1.0).count
    wrong = report("tb1", Pose2D(float("nan"), 0.0, 0.0), group.clock())
    with pytest.raises(InvalidInput, match="finite"):
        group.graph.inject("people_tracker/report", wrong)
    assert group.run(0.4).count == before == 1


def test_identities_stay_when_the_map_is_replaced(layers: MapLayers) -> None:
    group = Group(layers)
    (before,) = group.run(1.0).people
    node = group.graph.nodes["people_coordinator"]
    assert isinstance(node, PeopleCoordinatorNode)
    node.use_layers(build_layers(walled_map(6, 4, [(2.9, 0.5, 3.1, 1.0)])))
    (after,) = group.run(1.0).people
    assert after.id == before.id


def test_people_are_in_no_checkpoint_before_the_container_ends_for_lack_of_robots(layers: MapLayers) -> None:
    group = Group(layers)
    group.run(1.0)
    for _ in range(round(PEOPLE_LINGER)):
        group.clock.advance(1.0)
        group.graph.run_due()
    (checkpoint,) = group.graph.checkpoints()
    saved = msgspec.msgpack.decode(checkpoint.state)
    assert group.states[-1].people == saved["people"] == saved["orders"] == []
    assert saved["means"] == saved["covariances"] == b"" and saved["next_id"] == 2
