"""Messages of the master control are those of the published schemas, in all versions."""

import math

import pytest

from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import decode, encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.master.instructions import init_position, instant_action
from ppaas.wire.vda5050.topics import Address, Version
from tests.support.vda5050.led_agv import LedAgv, path
from tests.support.vda5050.schemas import problems


@pytest.mark.parametrize("version", Version)
def test_orders_and_updates_follow_the_schema(version):
    control = LedAgv(base_length=3.0)
    control.follow(path("a", *((2.0 * index, float(index % 2)) for index in range(8)), theta=math.pi))
    control.run(30.0)
    assert len(control.agv.orders) > 2
    headers = HeaderCounter(version, Address.of(version, "acme", "7"))
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
    header = HeaderCounter(version, Address.of(version, "acme", "7")).next(topics.INSTANT_ACTIONS, 1e9)
    payload = encode(topics.INSTANT_ACTIONS, header, message, version)
    assert problems(version, topics.INSTANT_ACTIONS, payload) == []
