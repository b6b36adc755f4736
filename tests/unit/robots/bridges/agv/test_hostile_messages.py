"""Messages of AGVs that are damaged or lie: nothing fails, and no goal is reached that is not."""

import asyncio

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.states import Connection, NodeState, Visualization
from ppaas.wire.vda5050.topics import Version
from tests.support.fuzzing import EXAMPLES
from tests.support.hostile_bytes import mutations
from tests.support.vda5050.fleet import FleetWithAgv
from tests.support.vda5050.led_agv import LedAgv, path
from tests.support.vda5050.messages import FACTSHEET, POSITION, VELOCITY

HOSTILE = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
GOAL = Pose2D(6.0, 4.0)
ROUTE = path("a", (0.0, 0.0), (6.0, 0.0), (6.0, 4.0))


def driving(version: Version) -> FleetWithAgv:
    """Return a fleet whose AGV has an order."""
    tested = FleetWithAgv(version)
    tested.say(topics.CONNECTION, Connection(connection_state="ONLINE"))
    tested.say(topics.STATE, tested.agv.state())
    tested.robot._follow(ROUTE)
    asyncio.run(tested.obey())
    return tested


def seeds() -> list[bytes]:
    found = []
    for version in Version:
        tested = driving(version)
        found += [
            tested.say(topics.STATE, tested.agv.state()),
            tested.say(topics.CONNECTION, Connection(connection_state="CONNECTION_BROKEN")),
            tested.say(topics.FACTSHEET, FACTSHEET),
            tested.say(topics.VISUALIZATION, Visualization(mobile_robot_position=POSITION, velocity=VELOCITY)),
        ]
    return found


TESTED = {version: driving(version) for version in Version}


@HOSTILE
@given(st.sampled_from(Version), st.sampled_from((*topics.FROM_AGV, "order", "")), mutations(seeds()), st.booleans())
def test_hostile_bytes_are_read_as_messages_of_an_agv(version, topic, payload, retained):
    tested = TESTED[version]
    tested.fleet.receive(f"{tested.address.topic(topic)}", payload, retained)
    tested.robot.tick()
    if len(tested.fleet.mqtt.outbox):
        asyncio.run(tested.obey())
    assert set(tested.fleet.robots) == {tested.address}


NAMES = st.sampled_from(["", "x", *(f"{ROUTE.id}-{index}" for index in range(3))])
NUMBERS = st.integers(-2, 8)


def lies(control: LedAgv) -> st.SearchStrategy[dict[str, object]]:
    """Return fields of a state that are not true, apart from the position."""
    known = [node.node_id for order in control.agv.orders for node in order.nodes]
    names = NAMES | st.sampled_from(known or [""])
    node = st.builds(NodeState, node_id=names, sequence_id=NUMBERS, released=st.booleans())
    return st.fixed_dictionaries(
        {},
        optional={
            "order_id": names | st.sampled_from([order.order_id for order in control.agv.orders] or [""]),
            "order_update_id": NUMBERS,
            "last_node_id": names,
            "last_node_sequence_id": NUMBERS,
            "driving": st.booleans(),
            "node_states": st.lists(node, max_size=3),
            "edge_states": st.just([]),
        },
    )


@HOSTILE
@given(st.data())
def test_hostile_bytes_are_read_as_lies_that_reach_no_goal(data):
    control = LedAgv(patience=1.0)
    control.follow(ROUTE)
    for _ in range(data.draw(st.integers(1, 6))):
        control.run(data.draw(st.sampled_from([0.5, 1.0, 3.0])))
        control.tell(control.agv.lie(**data.draw(lies(control))))
    reached = [end for end in control.ends if end.code == 0]
    assert len(control.ends) <= 1
    if reached:
        assert control.agv.pose.distance_to(GOAL) < 0.7
    control.run(8.0)
    control.ends.clear()
    x, y = control.agv.pose.x, control.agv.pose.y
    control.follow(path("next", (x, y), (x + 1.0, y)))
    control.run(12.0)
    assert control.end[0] == "NONE", "an honest AGV drives on"
