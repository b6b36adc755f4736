"""Codec of VDA 5050, checked against the published schemas."""

import json
from collections.abc import Iterator
from typing import Any, get_args

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, PPaaSError
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import BODIES, MAX_PAYLOAD, decode, encode
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.states import State
from ppaas.wire.vda5050.topics import Version
from tests.support.vda5050.damaged import HERE, damaged, payload_of
from tests.support.vda5050.schemas import problems


def changed(version: Version, topic: str, **fields: Any) -> bytes:
    return json.dumps({**json.loads(payload_of(version, topic)), **fields}).encode()


@pytest.mark.parametrize(("version", "topic"), HERE)
def test_messages_satisfy_the_published_schemas(version: Version, topic: str) -> None:
    assert problems(version, topic, payload_of(version, topic)) == []


@pytest.mark.parametrize(("version", "topic"), [one for one in HERE if one[1] != topics.VISUALIZATION])
def test_schemas_refuse_a_message_without_its_fields(version: Version, topic: str) -> None:
    assert problems(version, topic, b"{}")


@pytest.mark.parametrize("topic", BODIES)
def test_a_message_of_3_is_read_as_it_was_written(topic: str) -> None:
    header, body = decode(topic, payload_of(Version.V3_0, topic), Version.V3_0)
    assert (header.header_id, header.timestamp) == (0, "2026-09-21T14:13:20.125Z")
    again = encode(topic, header, body, Version.V3_0)
    assert json.loads(again) == json.loads(payload_of(Version.V3_0, topic))


@pytest.mark.parametrize(("version", "topic"), [(version, topic) for version, topic in HERE if version.major == 2])
def test_a_message_of_2_is_read_as_it_was_written(version: Version, topic: str) -> None:
    header, body = decode(topic, payload_of(version, topic), version)
    assert json.loads(encode(topic, header, body, version)) == json.loads(payload_of(version, topic))


def test_fields_have_the_names_of_the_version() -> None:
    old, new = (json.loads(payload_of(version, topics.STATE)) for version in (Version.V2_1, Version.V3_0))
    assert old["agvPosition"]["positionInitialized"] is new["mobileRobotPosition"]["localized"] is True
    assert old["batteryState"]["batteryCharge"] == new["powerSupply"]["stateOfCharge"] == 80.0
    assert [one["actionId"] for one in old["actionStates"]] == ["a1", "i1"]
    assert [one["actionId"] for one in new["instantActionStates"]] == ["i1"]
    assert "plannedPath" in new and "plannedPath" not in old


def test_a_radius_of_2_is_a_circle_of_3() -> None:
    payload = payload_of(Version.V2_1, topics.ORDER)
    assert json.loads(payload)["nodes"][0]["nodePosition"]["allowedDeviationXY"] == 0.3
    _, order = decode(topics.ORDER, payload, Version.V2_1)
    circle = order.nodes[0].node_position.allowed_deviation_xy
    assert (circle.a, circle.b) == (0.3, 0.3)


def test_parameters_of_actions_are_left_alone() -> None:
    action = {"actionType": "x", "actionId": "1", "blockingType": "NONE", "actionDescription": "said"}
    value = {"maxSpeed": 1.0, "sequenceId": 2.0, "eStop": "AUTOACK"}
    payload = changed(
        Version.V2_1, topics.INSTANT_ACTIONS, actions=[{**action, "actionParameters": [{"key": "k", "value": value}]}]
    )
    _, body = decode(topics.INSTANT_ACTIONS, payload, Version.V2_1)
    assert body.actions[0].parameter("k") == value
    assert body.actions[0].action_descriptor == "said"


def test_unknown_fields_are_ignored_and_optional_ones_absent() -> None:
    _, order = decode(topics.ORDER, changed(Version.V3_0, topics.ORDER, vendor={"a": [1]}), Version.V3_0)
    assert order.order_id == "o1" and order.zone_set_id is None


def test_instant_actions_of_2_have_two_names() -> None:
    payload = json.loads(payload_of(Version.V2_0, topics.INSTANT_ACTIONS))
    assert payload["actions"] == payload.pop("instantActions")
    payload["instantActions"] = payload.pop("actions")
    _, body = decode(topics.INSTANT_ACTIONS, json.dumps(payload).encode(), Version.V2_0)
    assert [one.action_id for one in body.actions] == ["i1"]


def test_whole_numbers_may_be_written_as_floats() -> None:
    _, order = decode(topics.ORDER, changed(Version.V2_0, topics.ORDER, orderUpdateId=4.0), Version.V2_0)
    assert order.order_update_id == 4


def test_visualizations_of_2_may_lack_the_header() -> None:
    header, body = decode(topics.VISUALIZATION, b"{}", Version.V2_1)
    assert header.serial_number == "" and body.velocity is None
    with pytest.raises(MalformedMessage, match="headerId"):
        decode(topics.VISUALIZATION, b"{}", Version.V3_0)


@pytest.mark.parametrize(
    ("version", "fields", "named"),
    [
        (Version.V2_1, {"agvPosition": {"x": 1.0}}, r"\$\.agvPosition"),
        (
            Version.V2_1,
            {"batteryState": {"batteryCharge": "full", "charging": False}},
            r"\$\.batteryState\.batteryCharge",
        ),
        (Version.V3_0, {"operatingMode": "SLEEPY"}, r"\$\.operatingMode"),
        (Version.V3_0, {"nodeStates": None}, r"\$\.nodeStates"),
    ],
)
def test_errors_name_the_field_as_it_was_spelled(version: Version, fields: dict[str, Any], named: str) -> None:
    with pytest.raises(MalformedMessage, match=named):
        decode(topics.STATE, changed(version, topics.STATE, **fields), version)


def test_another_major_version_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"'version' is '3\.0\.0'"):
        decode(topics.CONNECTION, payload_of(Version.V3_0, topics.CONNECTION), Version.V2_1)
    _, body = decode(topics.CONNECTION, payload_of(Version.V2_0, topics.CONNECTION), Version.V2_1)
    assert body.connection_state == "ONLINE"


def test_an_unknown_topic_is_refused() -> None:
    with pytest.raises(InvalidInput, match="unknown topic 'orders'"):
        decode("orders", b"{}", Version.V2_1)


@pytest.mark.parametrize("payload", [b"", b"[]", b"1", b"\xff", b"[" * 100_000, b'{"a":' * 40 + b"1" + b"}" * 40])
def test_garbage_is_refused(payload: bytes) -> None:
    with pytest.raises(MalformedMessage):
        decode(topics.ORDER, payload, Version.V2_1)


def test_a_large_payload_is_refused() -> None:
    with pytest.raises(MessageTooLarge):
        decode(topics.ORDER, b" " * (MAX_PAYLOAD + 1), Version.V2_1)


@given(damaged() | st.tuples(st.sampled_from(Version), st.sampled_from([*BODIES]), st.binary(max_size=64)))
def test_damaged_messages_are_read_or_refused(given: tuple[Version, str, bytes]) -> None:
    version, topic, payload = given
    try:
        header, body = decode(topic, payload, version)
    except PPaaSError as error:
        assert len(str(error)) < 500
    else:
        encode(topic, header, body, version)


def optional_fields(struct: type[Fields], seen: set[type]) -> Iterator[tuple[type[Fields], str]]:
    """Yield the optional fields of a struct and of those in it."""
    if struct in seen:
        return
    seen.add(struct)
    for one in msgspec.structs.fields(struct):
        if not one.required:
            yield struct, one.encode_name
        for inner in structs_in(one.type):
            yield from optional_fields(inner, seen)


def structs_in(kind: Any) -> Iterator[type[Fields]]:
    if isinstance(kind, type) and issubclass(kind, Fields):
        yield kind
    for inner in get_args(kind):
        yield from structs_in(inner)


def test_null_is_taken_for_every_optional_field_as_if_it_were_left_out() -> None:
    found = [one for body in BODIES.values() for one in optional_fields(body, set())]
    assert ("information" in {name for _, name in found}) and len(found) > 100
    for struct, name in found:
        kind = next(one.type for one in msgspec.structs.fields(struct) if one.encode_name == name)
        assert msgspec.convert(None, kind) is None, f"{struct.__name__}.{name}"


@pytest.mark.parametrize("version", Version)
def test_a_state_with_null_for_what_it_leaves_out_is_read(version: Version) -> None:
    names = {one.encode_name for one in msgspec.structs.fields(State) if not one.required}
    spelled = {("agvPosition" if name == "mobileRobotPosition" and version.major < 3 else name) for name in names}
    payload = changed(version, topics.STATE, **dict.fromkeys(spelled))
    state = decode(topics.STATE, payload, version)[1]
    assert state.information is None and state.velocity is None and state.mobile_robot_position is None


def test_kinematics_have_the_names_of_the_schemas_of_3_0_0_and_3_0_1() -> None:
    sent = json.loads(payload_of(Version.V3_0, topics.FACTSHEET))
    own = sent["typeSpecification"]
    assert own["mobileRobotKinematic"] == own["mobileRobotKinematics"] == "DIFFERENTIAL"
    del own["mobileRobotKinematics"]
    read = decode(topics.FACTSHEET, json.dumps(sent).encode(), Version.V3_0)[1]
    assert read.type_specification.mobile_robot_kinematics == "DIFFERENTIAL"


@pytest.mark.parametrize("zone_set", [None, [], {}, {"zones": 7}, {"zones": [None, {"zoneType": ["DIRECTED"]}]}])
def test_a_set_of_zones_that_is_none_is_refused(zone_set: object) -> None:
    with pytest.raises(MalformedMessage):
        decode(topics.ZONE_SET, changed(Version.V3_0, topics.ZONE_SET, zoneSet=zone_set), Version.V3_0)


# -- factsheets that lack parts ----------------------------------------------------------------------------------------

PARTS = ["typeSpecification", "protocolLimits", "protocolFeatures", "loadSpecification"]
BOTH = [Version.V2_1, Version.V3_0]


@pytest.mark.parametrize("version", BOTH)
def test_a_factsheet_that_is_a_header_alone_is_read(version: Version) -> None:
    sent = json.loads(payload_of(version, topics.FACTSHEET))
    bare = {name: part for name, part in sent.items() if not isinstance(part, dict)}
    header, sheet = decode(topics.FACTSHEET, json.dumps(bare).encode(), version)
    assert (header.serial_number, sheet) == (sent["serialNumber"], Factsheet())
    assert json.loads(encode(topics.FACTSHEET, header, sheet, version)) == bare


@pytest.mark.parametrize("version", BOTH)
@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("part", [7, [], "", None, {"seriesName": 7, "timing": 7, "agvActions": 7}])
def test_a_part_of_a_factsheet_that_cannot_be_read_counts_as_left_out(version: Version, name: str, part: Any) -> None:
    whole = decode(topics.FACTSHEET, payload_of(version, topics.FACTSHEET), version)[1]
    read = decode(topics.FACTSHEET, changed(version, topics.FACTSHEET, **{name: part}), version)[1]
    own = next(one.name for one in msgspec.structs.fields(Factsheet) if one.encode_name == name)
    assert read == msgspec.structs.replace(
        whole, **{own: part if name == PARTS[3] and isinstance(part, dict) else None}
    )


@pytest.mark.parametrize("version", BOTH)
@pytest.mark.parametrize("size", [7, {}, {"width": "wide"}])
def test_a_size_that_cannot_be_read_is_refused(version: Version, size: object) -> None:
    with pytest.raises(MalformedMessage, match="factsheet"):
        decode(topics.FACTSHEET, changed(version, topics.FACTSHEET, physicalParameters=size), version)
