import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, NotFound, NotPermitted, PPaaSError, Unavailable
from ppaas.messages import decode
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Float64, String
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from ppaas.wire import operations, rosbridge
from ppaas.wire.rosbridge_client import ReceivedMessage, RosbridgeClientSession, ServiceResult, StatusReport, failure_of


def test_the_server_side_decodes_all_frames_of_the_client() -> None:
    client, server = RosbridgeClientSession(), rosbridge.RosbridgeSession()
    subscribe = server.receive(client.subscribe("/cmd_vel", Twist, throttle=0.25, queue_length=1))
    assert isinstance(subscribe, operations.Subscribe)
    assert (subscribe.type, subscribe.throttle_rate, subscribe.queue_length) == ("geometry_msgs/Twist", 250, 1)
    assert server.subscribed() == {"cmd_vel"}
    publish = server.receive(client.publish("odd", Float64(float("nan"))))
    assert isinstance(publish, operations.Publish)
    assert bytes(publish.msg) == b'{"data":null}'
    call_id, frame = client.call("move_base/clear_costmaps", Empty())
    call = server.receive(frame)
    assert isinstance(call, operations.CallService)
    assert (call.id, bytes(call.args)) == (call_id, b"{}")
    server.receive(client.unsubscribe("cmd_vel"))
    assert server.subscribed() == frozenset()


def test_the_client_decodes_all_frames_of_the_server() -> None:
    client, server = RosbridgeClientSession(), rosbridge.RosbridgeSession("error")
    server.receive(client.subscribe("cmd_vel", Twist))
    [frame] = server.publish("cmd_vel", b'{"linear":{"x":0.5},"angular":{}}', 0.0)
    message = client.receive(frame)
    assert isinstance(message, ReceivedMessage)
    assert decode(Twist, message.msg) == Twist(Vector3(x=0.5))
    _, frame = client.call("stop", Empty())
    call = server.receive(frame)
    assert isinstance(call, operations.CallService)
    answer = client.receive(server.answer(call, b'{"success":true}'))
    assert isinstance(answer, ServiceResult)
    assert failure_of(answer) is None
    status = server.status(NotPermitted("not yours"))
    assert status is not None
    report = client.receive(status)
    assert isinstance(report, StatusReport)
    assert (type(report.error()), str(report.error())) == (NotPermitted, "not yours")


def test_a_refused_call_gives_its_reason() -> None:
    client, server = RosbridgeClientSession(), rosbridge.RosbridgeSession()
    call = server.receive(client.call("stop", Empty())[1])
    assert isinstance(call, operations.CallService)
    answer = client.receive(server.refuse_call(call, NotFound("service", "stop")))
    assert isinstance(answer, ServiceResult)
    failure = failure_of(answer)
    assert isinstance(failure, PPaaSError)
    assert "unknown service 'stop'" in str(failure)


def test_service_offered_by_the_client_is_called_and_answered() -> None:
    client, server = RosbridgeClientSession(), rosbridge.RosbridgeSession()
    offer = server.receive(client.advertise_service("/lights", Trigger))
    assert isinstance(offer, operations.AdvertiseService)
    assert (offer.service, offer.type) == ("/lights", "std_srvs/Trigger")
    call = client.receive(server.request("/lights", 7, b"{}"))
    assert isinstance(call, operations.CallService)
    assert (call.service, call.id, bytes(call.args)) == ("/lights", "7", b"{}")
    answer = server.receive(client.respond(call, TriggerResponse(True, "on")))
    assert isinstance(answer, operations.ServiceResponse)
    assert (answer.id, answer.result, bytes(answer.values)) == ("7", True, b'{"success":true,"message":"on"}')
    refusal = server.receive(client.refuse(call, NotPermitted("not now")))
    assert isinstance(refusal, operations.ServiceResponse)
    assert (refusal.result, bytes(refusal.values)) == (False, b'"not-permitted: not now"')
    assert isinstance(server.receive(client.unadvertise_service("lights")), operations.UnadvertiseService)


def test_a_failure_without_a_reason_names_the_service() -> None:
    failure = failure_of(ServiceResult("stop", False))
    assert failure is not None
    assert "'stop' failed without a reason" in str(failure)


def test_answers_to_abandoned_calls_are_ignored() -> None:
    client = RosbridgeClientSession()
    call_id, _ = client.call("stop", Empty())
    answer = json.dumps({"op": "service_response", "service": "stop", "id": call_id, "values": {}, "result": True})
    client.give_up(call_id)
    assert client.receive(answer) is None
    assert client.receive('{"op":"service_response","service":"stop","values":{},"result":true}') is None


def test_a_lost_connection_loses_the_calls_and_keeps_subscriptions_and_offers() -> None:
    client = RosbridgeClientSession()
    offer = client.advertise_service("lights", Trigger)
    client.advertise_service("horn", Trigger)
    client.unadvertise_service("/horn")
    client.subscribe("cmd_vel", Twist)
    wanted = client.subscribe("chatter", String)
    client.unsubscribe("/cmd_vel")
    call_id, _ = client.call("stop", Empty())
    lost = client.disconnected()
    assert list(lost) == [call_id]
    assert isinstance(lost[call_id], Unavailable)
    assert client.disconnected() == {}
    assert client.reconnected() == [wanted, offer]


@pytest.mark.parametrize("name", ["", "5", "a b", "a//b", "x" * 256])
def test_invalid_names_are_refused_before_sending(name: str) -> None:
    client = RosbridgeClientSession()
    for act in (
        lambda: client.publish(name, String("x")),
        lambda: client.subscribe(name, String),
        lambda: client.call(name, Empty()),
        lambda: client.advertise_service(name, Trigger),
    ):
        with pytest.raises(MalformedMessage):
            act()
    assert client.reconnected() == []


@given(st.one_of(st.binary(), st.text(), st.recursive(st.none() | st.text(), st.lists).map(json.dumps)))
def test_arbitrary_frames_are_malformed(frame: str | bytes) -> None:
    with pytest.raises(MalformedMessage):
        RosbridgeClientSession().receive(frame)
