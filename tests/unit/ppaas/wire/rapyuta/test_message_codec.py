"""Codecs of interfaces on robots."""

import json

import pytest

from ppaas.errors import InvalidInput, UnknownType
from ppaas.wire.rapyuta.interface_types import interface_type
from ppaas.wire.rapyuta.message_codec import codecs_of, graph_class


def test_a_client_of_a_service_receives_requests_and_sends_responses() -> None:
    sends, receives = codecs_of(interface_type("ServiceClientConverter"), "nav_msgs/GetPlan")
    request = json.dumps({"start": {"header": {"stamp": {"secs": 1, "nsecs": 0}}}}).encode()
    assert receives.write(request)["start"]["header"]["stamp"] == "1970-01-01T00:00:01.000000"
    response = {"plan": {"header": {"stamp": "1970-01-01T00:00:01"}, "poses": []}}
    assert json.loads(sends.read(response))["plan"]["header"]["stamp"] == {"secs": 1, "nsecs": 0}


def test_a_provider_sends_requests_and_receives_responses() -> None:
    sends, receives = codecs_of(interface_type("ServiceProviderConverter"), "nav_msgs/GetPlan")
    assert json.loads(sends.read({"start": {"header": {"stamp": "1970-01-01T00:00:01"}}}))["start"]["header"]["stamp"]
    assert receives.write(b'{"plan": {"poses": []}}') == {"plan": {"poses": []}}


def test_tf_has_its_name_of_2013() -> None:
    assert graph_class("tf/tfMessage") == "tf2_msgs/TFMessage"
    sends, _ = codecs_of(interface_type("SubscriberForwarder"), "tf/tfMessage")
    assert json.loads(sends.read(sends.write(b'{"transforms": []}'))) == {"transforms": []}


def test_types_of_the_robot_itself_pass_through_a_converter() -> None:
    sends, _ = codecs_of(interface_type("SubscriberConverter"), "my_msgs/Lamp")
    assert json.loads(sends.read({"on": True})) == {"on": True}
    sends, _ = codecs_of(interface_type("ServiceProviderConverter"), "my_msgs/SwitchLamp")
    assert json.loads(sends.read({"on": True})) == {"on": True}


def test_interfaces_of_containers_and_odd_names_are_refused() -> None:
    with pytest.raises(InvalidInput, match="converter or a forwarder"):
        codecs_of(interface_type("PublisherInterface"), "std_msgs/String")
    with pytest.raises(UnknownType):
        codecs_of(interface_type("PublisherConverter"), "String")
