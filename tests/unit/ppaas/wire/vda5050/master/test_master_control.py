"""Master control of an AGV: orders, updates, cancellation, restarts, and AGVs that lie."""

import math

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode, encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.master.instructions import init_position, instant_action
from ppaas.wire.vda5050.master.master_control import MasterControl
from ppaas.wire.vda5050.states import ConnectionState, Error, NodeState, SafetyState
from ppaas.wire.vda5050.topics import AgvAddress, Version
from tests.support.vda5050.led_agv import LedAgv, path
from tests.support.vda5050.schemas import problems
from tests.support.vda5050.simple_agv import SimpleAgv

CORNER = path("a", (0.0, 0.0), (6.0, 0.0), (6.0, 4.0), theta=1.0)
LONG = path("long", *((2.0 * index, float(index % 2)) for index in range(20)))


def led(**settings: float) -> LedAgv:
    return LedAgv(**settings)


def kinds(agv: SimpleAgv) -> list[str]:
    return [action.action_type for action in agv.actions]


def test_an_agv_drives_the_corners_of_its_path():
    control = led()
    control.follow(CORNER)
    (order,) = control.agv.orders
    assert [node.sequence_id for node in order.nodes] == [0, 2, 4]
    assert [edge.sequence_id for edge in order.edges] == [1, 3]
    assert [node.node_position.theta for node in order.nodes if node.node_position] == [None, None, 1.0]
    assert all(node.released for node in order.nodes)
    control.run(12.0)
    assert control.end == ("NONE", "")
    assert control.agv.pose.distance_to(Pose2D(6.0, 4.0)) < 1e-9
    assert control.agv.orders == [order], "it was sent once"
    assert not control.complaints


def test_progress_tells_the_rest_of_the_path():
    control = led()
    control.follow(CORNER)
    control.run(2.0)
    assert control.progress is not None
    assert (control.progress.path, control.progress.text) == ("a", "")
    assert control.progress.distance == pytest.approx(10.0)
    control.run(5.0)
    assert control.progress.distance == pytest.approx(4.0)


def test_a_long_path_is_released_piece_by_piece():
    agv = SimpleAgv()
    control = LedAgv(agv, base_length=8.0)
    control.follow(LONG)
    assert not all(node.released for node in agv.orders[0].nodes)
    control.run(60.0)
    assert control.end == ("NONE", "")
    assert [order.order_update_id for order in agv.orders] == list(range(len(agv.orders)))
    assert len({order.order_id for order in agv.orders}) == 1
    for before, after in zip(agv.orders, agv.orders[1:], strict=False):
        base = [node for node in before.nodes if node.released]
        assert after.nodes[0].node_id == base[-1].node_id, "an update begins at the end of the base"
    assert not control.complaints


def test_a_path_longer_than_a_message_is_sent_in_several():
    agv = SimpleAgv()
    control = LedAgv(agv, max_nodes=4, base_length=100.0)
    control.follow(LONG)
    control.run(80.0)
    assert control.end[0] == "NONE"
    assert all(len(order.nodes) <= 4 for order in agv.orders)


def test_a_cancelled_path_cancels_the_order():
    control = led()
    control.follow(CORNER)
    control.run(2.0)
    control.do(control.control.cancel("a", control.now))
    control.run(2.0)
    assert kinds(control.agv) == ["cancelOrder"]
    assert not control.ends
    assert control.control.order is None
    pose = control.agv.pose
    control.run(2.0)
    assert control.agv.pose == pose


def test_another_path_cancels_the_order_and_sends_another():
    control = led()
    control.follow(CORNER)
    control.run(2.0)
    control.follow(path("b", (2.0, 0.0), (0.0, 0.0), (0.0, 3.0)))
    control.run(20.0)
    assert kinds(control.agv) == ["cancelOrder"]
    assert control.ends[-1].path == "b"
    assert control.end == ("NONE", "")
    assert control.agv.pose.distance_to(Pose2D(0.0, 3.0)) < 1e-9


def test_a_path_that_leads_on_is_an_update_of_the_order():
    control = led()
    control.follow(CORNER)
    control.run(2.0)
    control.follow(path("b", (2.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)))
    control.run(30.0)
    assert not control.agv.actions
    first, second = control.agv.orders
    assert second.order_id == first.order_id
    assert second.nodes[0].node_id == first.nodes[-1].node_id
    assert (control.end, control.ends[0].path) == (("NONE", ""), "b")
    assert control.agv.pose.distance_to(Pose2D(0.0, 4.0)) < 1e-9


def test_the_rest_of_the_path_under_another_id_sends_nothing():
    """The next container of a clone plans again from where the robot is."""
    control = led()
    control.follow(CORNER)
    control.run(2.0)
    control.follow(path("b", (2.0, 0.05), (6.0, 0.0), (6.0, 4.0), theta=1.0))
    control.run(12.0)
    assert len(control.agv.orders) == 1
    assert control.ends[0].path == "b"
    assert control.end == ("NONE", "")


def test_a_lost_order_is_sent_again_and_given_up_after_three_times():
    control = led(patience=2.0)
    control.lost = True
    control.follow(CORNER)
    control.run(3.0)
    control.lost = False
    control.run(20.0)
    assert control.end == ("NONE", "")
    deaf = led(patience=2.0)
    deaf.agv.deaf = True
    deaf.follow(CORNER)
    deaf.run(7.0)
    assert deaf.end == ("PATIENCE_EXCEEDED", "the AGV has not taken its order, sent 3 times")


def test_a_rejected_order_ends_its_path_with_the_reason():
    control = led()
    control.agv.reject = "noRouteError: no way to node 2"
    control.follow(CORNER)
    control.run(0.5)
    assert control.end == ("INVALID_PATH", "the AGV rejects the order: noRouteError: no way to node 2")


# -- restarts ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("after", [0.0, 2.0, 8.0])
def test_a_bridge_that_was_killed_takes_its_order_up(after):
    control = led(base_length=5.0)
    control.follow(CORNER)
    control.run(after)
    before = len(control.agv.orders)
    control.restart()
    control.follow(CORNER)
    assert len(control.agv.orders) == before, "the order is not sent twice"
    control.run(20.0)
    assert control.end == ("NONE", "")
    assert not control.agv.actions
    assert len({order.order_id for order in control.agv.orders}) == 1


def test_an_order_that_ended_while_the_bridge_was_away_ends_its_path():
    control = led()
    control.follow(CORNER)
    control.agv.drive(0.5)
    control.agv.drive(60.0)
    control.agv.drive(0.5)
    control.restart()
    control.follow(CORNER)
    assert control.end == ("NONE", "")


def test_an_order_whose_path_is_gone_after_a_restart_is_cancelled():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.restart()
    control.run(2.0)
    assert not control.agv.actions, "the path may still come"
    control.run(3.0)
    assert kinds(control.agv) == ["cancelOrder"]


def test_an_order_is_left_alone_until_the_cloud_has_said_whether_it_has_a_path():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.control = MasterControl(control.settings)
    control.do(control.control.take_connection("ONLINE", control.now))
    control.run(5.0)
    assert not control.agv.actions
    control.control.ask_again(control.now)
    control.follow(CORNER)
    control.run(10.0)
    assert control.end == ("NONE", "")
    assert not control.agv.actions


def test_an_order_of_somebody_else_is_left_alone():
    control = led()
    control.agv.take_order(msgspec.structs.replace(_order_of(CORNER), order_id="transport 7"))
    control.tell()
    control.follow(path("b", (0.0, 0.0), (1.0, 0.0)))
    control.run(5.0)
    assert control.end == ("UNKNOWN", "the AGV drives order 'transport 7' of somebody else")
    assert not control.agv.actions


def _order_of(one):
    other = led()
    other.follow(one)
    return other.agv.orders[0]


# -- AGVs that are away ------------------------------------------------------------------------------------------------


def test_an_agv_that_goes_offline_ends_its_path():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.do(control.control.take_connection("OFFLINE", control.now))
    assert control.end == ("FAILED_TO_MAKE_PROGRESS", "the AGV is OFFLINE")


def test_a_broken_connection_is_waited_for():
    control = led(offline_patience=10.0)
    control.follow(CORNER)
    control.run(1.0)
    control.do(control.control.take_connection("CONNECTION_BROKEN", control.now))
    control.now += 5.0
    control.do(control.control.tick(control.now))
    assert control.progress is not None
    assert control.progress.text == "the connection of the AGV has been broken for 5 s"
    control.do(control.control.take_connection("ONLINE", control.now))
    control.run(20.0)
    assert control.end[0] == "NONE"
    assert len(control.agv.orders) == 1


def test_a_connection_that_stays_broken_ends_the_path():
    control = led(offline_patience=10.0)
    control.follow(CORNER)
    control.run(1.0)
    control.do(control.control.take_connection("CONNECTION_BROKEN", control.now))
    control.now += 11.0
    control.do(control.control.tick(control.now))
    assert control.end == ("FAILED_TO_MAKE_PROGRESS", "the connection of the AGV has been broken for 11 s")


def test_an_agv_that_must_not_drive_is_waited_for():
    control = led()
    stopped = SafetyState(active_emergency_stop="MANUAL", field_violation=False)
    control.tell(control.agv.lie(safety_state=stopped))
    control.follow(CORNER)
    assert not control.agv.orders
    control.tell(control.agv.lie(safety_state=stopped))
    assert control.progress is not None
    assert control.progress.text == "the emergency stop of the AGV is active (MANUAL)"
    control.run(15.0)
    assert control.end[0] == "NONE"


def test_an_agv_far_from_its_path_is_sent_nothing():
    control = led()
    control.follow(path("b", (5.0, 0.0), (8.0, 0.0)))
    assert control.end == ("INVALID_PATH", "the AGV is more than 1 m away from its path")
    assert not control.agv.orders


def test_a_fatal_error_ends_the_path():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    error = Error(error_type="motor", error_level="FATAL", error_description="too hot")
    control.tell(control.agv.lie(errors=[error]))
    assert control.end == ("FAILED_TO_MAKE_PROGRESS", "the AGV reports motor: too hot")
    control.run(1.0)
    assert kinds(control.agv) == ["cancelOrder"]


def test_an_agv_that_drops_its_order_ends_the_path():
    control = led()
    control.follow(CORNER)
    control.run(7.0)
    control.agv.forget()
    control.run(1.0)
    assert control.end == ("FAILED_TO_MAKE_PROGRESS", "the AGV dropped its order at node 1 of 2")


# -- AGVs that lie -----------------------------------------------------------------------------------------------------


def foreign(name: str, sequence: int) -> NodeState:
    return NodeState(node_id=name, sequence_id=sequence, released=True)


LIES = {
    "another order": ({"order_id": "mine"}, "it names order 'mine' in place of its own"),
    "a later update": ({"order_update_id": 7}, "it names update 7 of its order, whose newest is 0"),
    "a node that it was not given": (
        {"node_states": [foreign("x", 2)]},
        "it is to reach node 'x' (2), which its order does not have",
    ),
    "a sequence id of no node": ({"node_states": [foreign("x", 3)]}, "which its order does not have"),
    "a last node of another order": (
        {"last_node_id": "elsewhere", "last_node_sequence_id": 2},
        "the last node that it reached is node 'elsewhere' (2), which its order does not have",
    ),
}


@pytest.mark.parametrize("lie", LIES)
def test_a_lie_about_the_order_ends_the_path_in_words(lie):
    fields, text = LIES[lie]
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.tell(control.agv.lie(**fields))
    code, reason = control.end
    assert code == "FAILED_TO_MAKE_PROGRESS"
    assert reason.startswith("the AGV contradicts its order: ")
    assert text in reason
    assert control.complaints
    control.run(3.0)
    assert len(control.ends) == 1


def last_node(control: LedAgv, index: int) -> dict[str, object]:
    node = control.agv.orders[0].nodes[index]
    return {"last_node_id": node.node_id, "last_node_sequence_id": node.sequence_id}


def test_a_jump_to_the_last_node_does_not_reach_the_goal():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.now += 0.1
    control.tell(control.agv.lie(node_states=[], edge_states=[], driving=False, **last_node(control, 2)))
    code, reason = control.end
    assert code == "FAILED_TO_MAKE_PROGRESS"
    assert "it jumped 10.0 m along its route" in reason


def test_the_last_node_reached_far_away_does_not_reach_the_goal():
    control = led()
    control.follow(CORNER)
    control.run(3.0)
    control.now += 60.0
    control.tell(control.agv.lie(node_states=[], edge_states=[], driving=False, **last_node(control, 2)))
    assert "but is 5.00 m away from it" in control.end[1]


def test_a_step_back_is_a_lie():
    control = led()
    control.follow(CORNER)
    control.run(7.0)
    control.tell(control.agv.lie(**last_node(control, 0)))
    assert "it went back to node" in control.end[1]


def test_a_node_beyond_the_base_is_a_lie():
    control = LedAgv(SimpleAgv(), base_length=3.0, top_speed=100.0)
    control.follow(LONG)
    control.run(1.0)
    control.tell(control.agv.lie(**last_node(control, 8)))
    assert "beyond the end of its base" in control.end[1]


def test_an_agv_off_its_route_is_stopped_at_the_second_state():
    control = led()
    control.follow(CORNER)
    control.run(1.0)
    control.agv.pose = Pose2D(1.0, 3.0)
    control.tell()
    assert not control.ends, "one position may be wrong"
    control.tell()
    assert "it is 3.0 m off its route" in control.end[1]
    control.run(1.0)
    assert kinds(control.agv) == ["cancelOrder"]


def test_an_agv_that_does_not_cancel_is_complained_of():
    control = led(patience=1.0)
    control.follow(CORNER)
    control.run(1.0)
    control.lost = True
    control.follow(path("b", (1.0, 0.0), (0.0, 0.0), (0.0, 3.0)))
    control.run(4.5)
    assert control.end == ("PATIENCE_EXCEEDED", "the AGV does not cancel the order that it has")
    assert "it does not cancel order" in control.complaints[0]


REFUSED = "states of the AGV are left out: late message 3 on state"
LONG_WAY = path("a", (0.0, 0.0), (30.0, 0.0))


def test_no_order_begins_while_states_are_left_out():
    control = LedAgv()
    control.control.left_out = REFUSED
    control.follow(LONG_WAY)
    control.do(control.control.tick(control.now + 5.0))
    assert not control.agv.orders
    assert control.progress is not None and control.progress.text == REFUSED
    control.control.left_out = ""
    control.tell()
    assert len(control.agv.orders) == 1


@pytest.mark.parametrize("end", ["OFFLINE", "CONNECTION_BROKEN", "HIBERNATING"])
def test_an_order_begins_where_the_agv_is_once_its_connection_is_back(end: ConnectionState):
    control = LedAgv()
    control.do(control.control.take_connection(end, control.now))
    control.agv.pose = Pose2D(1.5, 0.0)
    control.follow(path("a", (1.5, 0.0), (6.0, 0.0)))
    control.do(control.control.take_connection("ONLINE", control.now))
    control.do(control.control.tick(control.now + 1.0))
    assert not control.agv.orders, "the newest state is from before"
    assert control.control.stale == "the AGV has sent no state since its connection began"
    control.tell()
    (order,) = control.agv.orders
    assert order.nodes[0].node_position is not None
    assert order.nodes[0].node_position.x == 1.5


def test_a_state_that_comes_after_the_end_of_the_connection_is_of_that_connection():
    control = LedAgv()
    control.do(control.control.take_connection("CONNECTION_BROKEN", control.now))
    control.tell()
    control.do(control.control.take_connection("ONLINE", control.now))
    assert control.control.stale


def test_an_order_does_not_grow_while_states_are_left_out_and_its_path_ends_after_a_while():
    control = LedAgv(base_length=4.0)
    control.follow(path("a", *((float(x), 0.5 * (x % 2)) for x in range(30))))
    control.run(1.0)
    orders = len(control.agv.orders)
    control.control.left_out = REFUSED
    for _ in range(40):
        control.now += 1.0
        control.agv.drive(1.0)
        control.do(control.control.tick(control.now))
    assert len(control.agv.orders) == orders
    code, reason = control.end
    assert code == "FAILED_TO_MAKE_PROGRESS"
    assert reason.endswith(REFUSED)
    assert [action.action_type for action in control.agv.actions][:1] == ["cancelOrder"]


def test_an_order_is_cancelled_while_states_are_left_out():
    control = LedAgv(SimpleAgv())
    control.follow(LONG_WAY)
    control.run(1.0)
    control.control.left_out = REFUSED
    control.do(control.control.cancel("a", control.now))
    assert [action.action_type for action in control.agv.actions] == ["cancelOrder"]


@pytest.mark.parametrize("version", Version)
def test_orders_and_updates_follow_the_schema(version):
    control = LedAgv(base_length=3.0)
    control.follow(path("a", *((2.0 * index, float(index % 2)) for index in range(8)), theta=math.pi))
    control.run(30.0)
    assert len(control.agv.orders) > 2
    headers = HeaderCounter(version, AgvAddress.of(version, "acme", "7"))
    for order in control.agv.orders:
        payload = encode(topics.ORDER, headers.next(topics.ORDER, 1e9), order, version)
        assert problems(version, topics.ORDER, payload) == []
        assert decode(topics.ORDER, payload, version)[1].nodes[0].node_id == order.nodes[0].node_id


@pytest.mark.parametrize("version", Version)
@pytest.mark.parametrize(
    "message",
    [
        instant_action("cancelOrder", 1.0),
        instant_action("stateRequest", 1.0),
        init_position(Pose2D(1.0, 2.0, 3.0), "hall", "", 1.0),
    ],
)
def test_instant_actions_follow_the_schema(version, message):
    header = HeaderCounter(version, AgvAddress.of(version, "acme", "7")).next(topics.INSTANT_ACTIONS, 1e9)
    payload = encode(topics.INSTANT_ACTIONS, header, message, version)
    assert problems(version, topics.INSTANT_ACTIONS, payload) == []
