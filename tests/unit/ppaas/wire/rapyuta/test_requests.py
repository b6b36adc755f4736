"""Requests of robots, as docs of the protocol show them."""

import itertools
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.wire.rapyuta import requests
from ppaas.wire.rapyuta.answers import MAX_ERROR, AnswerFrames, data_message, error_message, interface_status
from ppaas.wire.rapyuta.interface_types import TYPES, check_joinable, interface_type
from ppaas.wire.rapyuta.requests import MAX_ITEMS, MAX_MESSAGE_ID, read_request

NODE = {"containerTag": "c1", "nodeTag": "n1", "pkg": "amcl", "exe": "amcl"}
INTERFACE = {
    "endpointTag": "c1", "interfaceTag": "req", "interfaceType": "PublisherInterface", "className": "std_msgs/String",
    "addr": "/req",
}  # fmt: skip


def test_containers_are_created_with_and_without_wishes() -> None:
    assert read_request({"type": "CC", "data": {"containerTag": "c1"}}) == requests.CreateContainer("c1")
    wishes = {"group": "g", "groupIp": "10.0.0.1", "size": 2, "cpu": 1, "memory": 5, "bandwidth": 9.5,
              "specialFeatures": ["gpu"]}  # fmt: skip
    created = read_request({"type": "CC", "data": {"containerTag": "c1", "containerData": wishes}})
    assert isinstance(created, requests.CreateContainer) and created.containerData is not None
    assert (created.containerData.size, created.containerData.specialFeatures) == (2, ["gpu"])


def test_containers_are_destroyed() -> None:
    assert read_request({"type": "DC", "data": {"containerTag": "c1"}}) == requests.DestroyContainer("c1")


def test_a_configuration_has_any_of_six_lists() -> None:
    data = {
        "addNodes": [NODE, NODE | {"args": "_a:=1", "name": "n", "namespace": "s"}],
        "removeNodes": [{"containerTag": "c1", "nodeTag": "n1"}],
        "addInterfaces": [INTERFACE],
        "removeInterfaces": [{"endpointTag": "c1", "interfaceTag": "req"}],
        "setParam": [{"containerTag": "c1", "name": "/a", "value": value} for value in (1, 1.5, True, "x", [1, "y"])],
        "deleteParam": [{"containerTag": "c1", "name": "/a"}],
    }
    found = read_request({"type": "CN", "data": data})
    assert isinstance(found, requests.Configure)
    assert [node.namespace for node in found.addNodes] == ["", "s"]
    assert [parameter.value for parameter in found.setParam] == [1, 1.5, True, "x", [1, "y"]]
    assert found.addInterfaces[0].addr == "/req"
    assert read_request({"type": "CN", "data": {}}) == requests.Configure()


def test_interfaces_are_connected_and_disconnected() -> None:
    pair = {"tagA": "c1/req", "tagB": "R/req"}
    found = read_request({"type": "CX", "data": {"connect": [pair], "disconnect": [pair]}})
    assert found == requests.Connect(
        [requests.InterfacePair("c1/req", "R/req")], [requests.InterfacePair("c1/req", "R/req")]
    )


def test_a_message_may_have_bytes() -> None:
    data = {"iTag": "req", "type": "std_msgs/String", "msgID": "7", "msg": b"\0\1"}
    assert read_request({"type": "DM", "data": data}) == requests.DataMessage("req", "std_msgs/String", "7", b"\0\1")


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ({"data": {}}, "missing key: 'type'"),
        ({"type": "CC"}, "missing key: 'data'"),
        ({"type": "XX", "data": {}}, "not supported"),
        ({"type": ["CC"], "data": {}}, "not supported"),
        ({"type": "ER", "data": "no"}, "not supported"),
        ({"type": "CC", "data": {}}, "containerTag"),
        ({"type": "CC", "data": {"containerTag": 1}}, "containerTag"),
        ({"type": "CN", "data": {"addNodes": [{"containerTag": "c1"}]}}, "nodeTag"),
        ({"type": "CN", "data": {"setParam": [{"containerTag": "c1", "name": "a", "value": None}]}}, "value"),
        ({"type": "CN", "data": {"addNodes": [NODE] * (MAX_ITEMS + 1)}}, "1000"),
        ({"type": "DM", "data": {"iTag": "a", "type": "b", "msgID": "x" * (MAX_MESSAGE_ID + 1), "msg": {}}}, "255"),
        ([], "object"),
    ],
)
def test_other_messages_are_refused(message: Any, text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        read_request(message)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.binary(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["containerTag", "addNodes", "connect", "tagA", "iTag", "type", "msg", "msgID", "x"]), inner
        )
    ),
    max_leaves=10,
)


@given(st.sampled_from(["CC", "DC", "CN", "CX", "DM", "ST"]), JSON)
def test_any_data_is_a_request_or_refused(kind: str, data: Any) -> None:
    try:
        read_request({"type": kind, "data": data})
    except PPaaSError as error:
        assert str(error)


def test_a_message_has_four_fields() -> None:
    frames = data_message("req", "std_msgs/String", "7", {"data": "hi"})
    assert json.loads(frames.text) == {
        "type": "DM",
        "data": {"iTag": "req", "type": "std_msgs/String", "msgID": "7", "msg": {"data": "hi"}},
    }
    assert frames.parts == ()


def test_bytes_follow_their_message_with_their_uuid() -> None:
    frames = data_message("img", "sensor_msgs/CompressedImage", "7", {"format": "png", "data": b"\1\2"})
    message = json.loads(frames.text)["data"]["msg"]
    assert message.keys() == {"format", "data*"}
    assert frames.parts == (message["data*"].encode() + b"\1\2",)
    assert len(message["data*"]) == 32
    forwarded = data_message("img", "sensor_msgs/CompressedImage", "7", b"zlib")
    assert forwarded.parts == (json.loads(forwarded.text)["data"]["msg*"].encode() + b"zlib",)


def test_a_status_is_of_an_interface() -> None:
    expected = {"type": "ST", "data": {"topic": "iu", "iTag": "req", "status": True}}
    assert json.loads(interface_status("req", active=True).text) == expected


def test_errors_of_the_robot_are_invalid_requests() -> None:
    assert json.loads(error_message(InvalidInput("no")).text) == {"type": "ER", "data": "Invalid Request: no"}
    assert json.loads(error_message(NotFound("node", "a b", ["x y"])).text)["data"].endswith("known: 'x y'")
    assert json.loads(error_message(Unavailable("full")).text)["data"] == "full"
    assert json.loads(error_message(InvalidInput("Invalid Request: no")).text)["data"] == "Invalid Request: no"
    assert len(json.loads(error_message(InvalidInput("x" * 9999)).text)["data"]) == MAX_ERROR


@given(st.binary(max_size=9), st.lists(st.binary(max_size=9)))
def test_packed_frames_are_unpacked(text: bytes, parts: list[bytes]) -> None:
    frames = AnswerFrames(text, tuple(parts))
    assert AnswerFrames.unpack(frames.packed()) == frames


def test_there_are_four_roles_in_three_forms() -> None:
    roles, forms = (
        ("ServiceClient", "ServiceProvider", "Publisher", "Subscriber"),
        ("Interface", "Converter", "Forwarder"),
    )
    assert set(TYPES) == {"".join(parts) for parts in itertools.product(roles, forms)}
    assert all(str(interface_type(name)) == name for name in TYPES)


@pytest.mark.parametrize("name", ["", "Publisher", "Interface", "publisherInterface", "ServiceInterface", "PublisherX"])
def test_other_types_are_refused_with_those_that_exist(name: str) -> None:
    with pytest.raises(InvalidInput, match="ServiceClient, ServiceProvider"):
        interface_type(name)


def test_publishers_join_subscribers_and_clients_join_providers() -> None:
    pairs = {"Publisher": "Subscriber", "Subscriber": "Publisher"}
    pairs |= {"ServiceClient": "ServiceProvider", "ServiceProvider": "ServiceClient"}
    for names in itertools.product(TYPES, TYPES):
        one, other = ((interface_type(name), "std_msgs/String") for name in names)
        if pairs[one[0].role] == other[0].role:
            check_joinable(one, other)
        else:
            with pytest.raises(InvalidInput, match="Can not connect"):
                check_joinable(one, other)


def test_different_classes_do_not_join() -> None:
    one, other = interface_type("PublisherInterface"), interface_type("SubscriberConverter")
    with pytest.raises(InvalidInput, match="different classes"):
        check_joinable((one, "std_msgs/String"), (other, "std_msgs/Bool"))
