"""Node ``stop``: the latch, and that nothing but zero leaves a clone while it holds, whoever publishes."""

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.health.stops import ALL, MAP, ROBOT, RobotStop, StopRobotRequest, StopState
from ppaas.nodes import topics
from ppaas.nodes.base import Checkpoint, Node
from ppaas.nodes.graph import Graph
from ppaas.nodes.stop.node import BY_CLIENT, LONGEST_REASON, PERIOD, StopNode, VelocityLatch

DRIVE = Twist(Vector3(x=0.3), Vector3(z=0.1))
EVERY = RobotStop(ALL, "", "ann", 1000.0, "a pallet fell")
HALL = RobotStop(MAP, "hall", "bob", 1001.0)
OWN = RobotStop(ROBOT, "tb1", "ann", 1002.0)


class Driver(Node):
    """Publishes velocities, as Move Base does."""

    name = "driver"
    publishes = (topics.CMD_VEL,)


class Rig:
    """Graph with a driver and the node, whose velocities are heard from outside, as a robot hears them."""

    def __init__(self, stops: tuple[RobotStop, ...] = (), state: bytes = b"") -> None:
        self.clock = ManualClock(50.0)
        self.graph = Graph(clock=self.clock, stamp_clock=lambda: 1000.0 + self.clock())
        self.heard: list[Twist] = []
        self.states: list[StopState] = []
        self.graph.add(Driver)
        self.node = self.graph.add(lambda context: StopNode(context, self.graph, "tb1", stops))
        if state:
            self.graph.restore([Checkpoint("stop", state)])
        self.graph.tap(topics.CMD_VEL.name, lambda _, message: self.heard.append(message))  # type: ignore[arg-type]
        self.graph.tap(topics.STOP_STATE.name, lambda _, message: self.states.append(message))  # type: ignore[arg-type]

    def drive(self) -> None:
        self.graph.nodes["driver"].context.publish(topics.CMD_VEL.name, DRIVE)

    def inject(self) -> None:
        self.graph.inject(topics.CMD_VEL.name, DRIVE)

    def wait(self, seconds: float = PERIOD) -> None:
        self.clock.advance(seconds)
        self.graph.run_due()

    def request(self, reason: str = "") -> StopState:
        answers: list[StopState] = []
        self.graph.call("stop/request", StopRobotRequest(reason), answers.append)  # type: ignore[arg-type]
        (answer,) = answers
        return answer


# -- latch -------------------------------------------------------------------------------------------------------------


def test_the_latch_passes_velocities_until_there_is_a_stop() -> None:
    latch = VelocityLatch()
    assert latch.passed(DRIVE) is DRIVE
    latch.set([EVERY, OWN])
    assert latch.passed(DRIVE) == Twist()
    latch.set([OWN])
    assert latch.passed(DRIVE) == Twist()
    latch.set([])
    assert latch.passed(DRIVE) is DRIVE


def test_a_request_holds_until_the_cloud_has_a_stop_of_the_robot_and_releases_it() -> None:
    latch = VelocityLatch()
    latch.request(OWN)
    latch.set([EVERY])
    assert latch.requested == (OWN,), "the order was given before the cloud heard of the request"
    latch.set([])
    assert latch.is_stopped
    latch.set([OWN])
    latch.set([])
    assert not latch.is_stopped


def test_a_request_adds_nothing_to_a_stop_of_the_robot() -> None:
    latch = VelocityLatch([OWN])
    latch.request(RobotStop(ROBOT, "tb1", BY_CLIENT, 1.0))
    assert latch.in_force == (OWN,)


# -- node --------------------------------------------------------------------------------------------------------------


def test_zero_is_sent_at_once_and_again_and_again() -> None:
    rig = Rig()
    rig.drive()
    rig.node.set([EVERY])
    assert rig.heard == [DRIVE, Twist()]
    rig.wait()
    rig.wait()
    assert rig.heard == [DRIVE, Twist(), Twist(), Twist()]
    rig.node.set([])
    rig.wait()
    rig.inject()
    assert rig.heard[4:] == [DRIVE], "after the release nothing is sent by itself"


@pytest.mark.parametrize("publish", [Rig.drive, Rig.inject])
def test_velocities_of_nodes_and_of_clients_become_zero(publish: Callable[[Rig], None]) -> None:
    rig = Rig((HALL,))
    publish(rig)
    assert rig.heard == [Twist()]


def test_the_state_says_who_stopped_the_robot_and_cannot_be_forged() -> None:
    rig = Rig((EVERY,))
    rig.graph.inject(topics.STOP_STATE.name, StopState())
    state = decode(StopState, encode(rig.states[-1]))
    assert (state.stopped, state.stops) == (True, [EVERY])
    assert state.text == "all robots are stopped by 'ann' since 1970-01-01 00:16:40 UTC: a pallet fell"


def test_states_of_two_changes_differ_so_that_none_is_taken_for_an_earlier_one() -> None:
    rig = Rig()
    rig.wait(1.0)
    rig.node.set([OWN])
    rig.wait(1.0)
    rig.node.set([])
    first, _, last = rig.states
    assert (first.stopped, last.stopped) == (False, False)
    assert first != last


def test_a_client_stops_the_robot_and_the_request_outlives_the_container() -> None:
    rig = Rig()
    changes: list[None] = []
    rig.node.changed = lambda: changes.append(None)
    answer = rig.request("x" * 1000)
    assert (answer.stopped, answer.stops[0].by, len(answer.stops[0].reason)) == (True, BY_CLIENT, LONGEST_REASON)
    assert changes
    state = rig.node.checkpoint()
    again = Rig(state=state)
    again.drive()
    assert again.heard == [Twist()]


# -- property: no velocity but zero leaves while the latch holds -------------------------------------------------------

STOPS = st.lists(st.sampled_from([EVERY, HALL, OWN]), unique_by=lambda stop: stop.key)
EVENTS = st.lists(
    st.one_of(
        st.tuples(st.just("set"), STOPS),
        st.sampled_from([("drive", None), ("inject", None), ("request", None), ("wait", None), ("restart", None)]),
    ),
    max_size=40,
)


@settings(max_examples=150, deadline=None)
@given(EVENTS)
def test_nothing_but_zero_leaves_while_the_robot_is_stopped(events: list[tuple[str, list[RobotStop] | None]]) -> None:
    rig, stops, requested = Rig(), tuple[RobotStop, ...](), False
    for event, given_stops in events:
        before = len(rig.heard)
        match event:
            case "set":
                stops = tuple(given_stops or ())
                requested = requested and OWN not in stops
                rig.node.set(stops)
            case "request":
                rig.request()
                requested = requested or OWN not in stops
            case "restart":
                rig, before = Rig(stops, rig.node.checkpoint()), 0
            case _:
                getattr(rig, event)()
        sent = rig.heard[before:]
        if stops or requested:
            assert all(velocity == Twist() for velocity in sent)
            assert sent or event == "restart", "each event of a robot that is stopped sends zero"
        elif event in ("drive", "inject"):
            assert sent == [DRIVE]
