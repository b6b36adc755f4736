"""Keys and tokens, with the examples of ``docs/design.md`` of rmw_zenoh."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.graph import LATCHED, SENSOR, Entity, Kind, Qos
from ppaas.wire.ros.rmw_zenoh import (
    DEFAULT_DEPTH,
    ZenohNode,
    gid_of,
    pack_attachment,
    parse_token,
    ros_type,
    topic_key,
    unpack_attachment,
)

HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
TALKER = (
    "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/"
    f"{HASH}/::,7:,:,:,,"
)

NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
PATHS = st.lists(NAMES, min_size=1, max_size=3).map(lambda parts: "/" + "/".join(parts))


def test_the_key_of_a_topic_has_its_domain_type_and_hash() -> None:
    assert topic_key(0, "/chatter", "std_msgs/msg/String", HASH) == f"0/chatter/std_msgs::msg::dds_::String_/{HASH}"
    assert topic_key(7, "/a/b/", "std_srvs/srv/Empty") == "7/a/b/std_srvs::srv::dds_::Empty_/*"


def test_the_token_of_the_talker_is_read() -> None:
    talker = parse_token(TALKER)
    assert talker == Entity(Kind.PUBLISHER, "/chatter", "std_msgs/msg/String", Qos(depth=7), "/talker", TALKER, HASH)
    assert parse_token("@ros2_lv/2/8b20/0/0/NN/%/%/talker") is None, "a node is no entity"


def test_a_quality_of_service_that_states_no_depth_has_the_default_of_rmw_zenoh() -> None:
    entity = parse_token(TALKER.replace("::,7:", "2:1:,:"))
    assert entity is not None
    assert entity.qos == Qos(reliable=False, latched=True, depth=DEFAULT_DEPTH)


@given(st.sampled_from(Kind), PATHS, st.sampled_from([Qos(), LATCHED, SENSOR]), PATHS, NAMES)
def test_a_token_is_read_as_it_was_written(kind: Kind, topic: str, qos: Qos, namespace: str, name: str) -> None:
    node = ZenohNode(3, "ab12", namespace, name)
    entity = Entity(kind, topic, "nav2_msgs/action/Wait_SendGoal", qos, f"{namespace}/{name}", "", HASH)
    token = node.entity_token(5, entity)
    read = parse_token(token)
    assert read is not None
    assert (read.kind, read.name, read.type, read.qos, read.node, read.type_hash) == (
        kind, topic, entity.type, qos, entity.node, HASH
    )  # fmt: skip
    assert parse_token(node.token) is None


@given(
    st.text("@ros2_lv/%:,MPS0a", max_size=80)
    | st.tuples(st.integers(0, 100), st.text(max_size=5)).map(
        lambda cut: TALKER[: cut[0]] + cut[1] + TALKER[cut[0] + 1 :]
    )
)
def test_any_text_is_a_token_or_refused(text: str) -> None:
    with contextlib.suppress(MalformedMessage):
        parse_token(text)


@pytest.mark.parametrize(
    "token",
    [
        "",
        "@ros2_lv/0/a/0/1/MP/%/%/n/%t",
        TALKER.replace("::msg::", "."),
        TALKER.replace("::,7:", ""),
        TALKER + "x" * 2048,
    ],
)
def test_what_is_no_token_is_refused(token: str) -> None:
    with pytest.raises(MalformedMessage):
        parse_token(token)


def test_types_that_are_not_of_ros_are_refused() -> None:
    with pytest.raises(MalformedMessage, match="not the name of a type"):
        ros_type("std_msgs/String")


def test_an_attachment_has_the_number_and_the_sender() -> None:
    gid = gid_of(TALKER)
    assert len(gid) == 16
    data = pack_attachment(3, 4, gid)
    assert data == b"\3\0\0\0\0\0\0\0\4\0\0\0\0\0\0\0\x10" + gid
    assert unpack_attachment(data) == (3, gid)
    for wrong in (b"", data[:-1], data[:16] + b"\x0f" + gid):
        with pytest.raises(MalformedMessage):
            unpack_attachment(wrong)
