"""Answers of a server of Foxglove's protocol."""

import json
import struct

from hypothesis import given
from hypothesis import strategies as st

from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.foxglove import answers
from ppaas.wire.foxglove.answers import Channel, ConnectionGraph, FoxgloveService, Level, Schema
from ppaas.wire.foxglove.requests import Parameter

SCHEMA = Schema("json", "a/B", "jsonschema", '{"type": "object"}')


def test_channels_and_services_have_the_fields_of_the_specification() -> None:
    [channel] = json.loads(answers.advertise([Channel(3, "/tb1/scan", SCHEMA)]))["channels"]
    assert channel == {
        "id": 3,
        "topic": "/tb1/scan",
        "encoding": "json",
        "schemaName": "a/B",
        "schema": '{"type": "object"}',
        "schemaEncoding": "jsonschema",
    }
    [service] = json.loads(answers.advertise_services([FoxgloveService(1, "/s", "a/S", SCHEMA, SCHEMA)]))["services"]
    described = {key: channel[key] for key in ("encoding", "schemaName", "schemaEncoding", "schema")}
    assert service == {"id": 1, "name": "/s", "type": "a/S", "request": described, "response": described}


def test_texts_and_values() -> None:
    assert json.loads(answers.server_info("PPaaS", "one"))["supportedEncodings"] == ["json", "cdr", "ros1"]
    assert json.loads(answers.status(Level.ERROR, "no")) == {"op": "status", "level": 2, "message": "no"}
    assert json.loads(answers.status(Level.INFO, "no", "a"))["id"] == "a"
    assert json.loads(answers.remove_status(["a"])) == {"op": "removeStatus", "statusIds": ["a"]}
    assert json.loads(answers.unadvertise([1, 2])) == {"op": "unadvertise", "channelIds": [1, 2]}
    assert json.loads(answers.unadvertise_services([1])) == {"op": "unadvertiseServices", "serviceIds": [1]}
    assert json.loads(answers.service_failed(1, 2, "no")) == {
        "op": "serviceCallFailure", "serviceId": 1, "callId": 2, "message": "no",
    }  # fmt: skip
    values = answers.parameter_values([Parameter("/a", 1.5, "float64"), Parameter("/gone")], "mine")
    assert json.loads(values) == {
        "op": "parameterValues",
        "parameters": [{"name": "/a", "value": 1.5, "type": "float64"}, {"name": "/gone"}],
        "id": "mine",
    }


def test_binary_frames() -> None:
    frames = [
        answers.message_data(1, 2, b"x"),
        answers.time_data(3),
        answers.service_response(1, 2, "json", b"{}"),
        answers.asset_failed(4, "none"),
    ]
    assert all(isinstance(frame, BinaryFrame) for frame in frames)
    assert frames == [
        struct.pack("<BIQ", 1, 1, 2) + b"x",
        struct.pack("<BQ", 2, 3),
        struct.pack("<BIII", 3, 1, 2, 4) + b"json{}",
        struct.pack("<BIBI", 4, 4, 1, 4) + b"none",
    ]


NODES = st.dictionaries(st.sampled_from("abcd"), st.lists(st.sampled_from("xyz"), unique=True, min_size=1), max_size=4)
GRAPHS = st.builds(ConnectionGraph, NODES, NODES, NODES)


@given(GRAPHS, GRAPHS)
def test_changes_turn_one_graph_into_the_other(before: ConnectionGraph, after: ConnectionGraph) -> None:
    changes = before.changes_to(after)
    if before == after:
        assert changes is None
        return
    assert changes is not None
    read = json.loads(changes)
    applied = []
    for old, listed, key in (
        (before.published, "publishedTopics", "publisherIds"),
        (before.subscribed, "subscribedTopics", "subscriberIds"),
        (before.services, "advertisedServices", "providerIds"),
    ):
        removed = read["removedServices" if listed == "advertisedServices" else "removedTopics"]
        now = {**old, **{one["name"]: one[key] for one in read[listed]}}
        applied.append({name: nodes for name, nodes in now.items() if nodes and name not in removed})
    assert ConnectionGraph(*applied) == after
