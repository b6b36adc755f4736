"""What is not known of an AGV any more: no order begins or grows by it."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050.states import ConnectionState
from tests.support.vda5050.led_agv import LedAgv, path
from tests.support.vda5050.simple_agv import SimpleAgv

REFUSED = "states of the AGV are left out: late message 3 on state"
LONG = path("a", (0.0, 0.0), (30.0, 0.0))


def test_no_order_begins_while_states_are_left_out():
    control = LedAgv()
    control.control.left_out = REFUSED
    control.follow(LONG)
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
    control.follow(LONG)
    control.run(1.0)
    control.control.left_out = REFUSED
    control.do(control.control.cancel("a", control.now))
    assert [action.action_type for action in control.agv.actions] == ["cancelOrder"]
