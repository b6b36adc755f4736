import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from engine.fabric.keys import (
    COORDINATOR,
    TRAFFIC_NODE,
    Scope,
    SharedKey,
    addressed_key,
    chunk,
    parse_shared,
    shared_by_all,
    shared_by_user,
    shared_key,
    topic_key,
)
from ppaas.errors import InvalidParameter, NotPermitted

names = st.text(st.characters(codec="utf-8"), min_size=1, max_size=12)
topics = st.from_regex(r"[a-z][a-z0-9_]{0,5}(/[a-z0-9_]{1,5}){0,2}", fullmatch=True)
ANN = Scope("ann", "lab", "tb1", "house")


def test_a_key_names_user_group_robot_and_topic():
    assert ANN.private_key("/move_base/goal") == "ppaas/ann/lab/tb1/move_base/goal"
    assert ANN.shared_key("position") == "ppaas/map/house/ann/tb1/position"


@given(names, names, names, topics)
def test_any_name_makes_a_unique_key_that_zenoh_accepts(user, group, robot, topic):
    key = topic_key(user, group, robot, topic)
    assert str(zenoh.KeyExpr(key)) == key
    assert len(key.split("/")) == 4 + len(topic.split("/"))
    assert not set("*$?#") & set(key)


@given(names, names)
def test_different_names_make_different_chunks(one, other):
    assert (chunk(one) == chunk(other)) == (one == other)


@given(names, names, names, topics)
def test_a_shared_key_is_parsed_into_its_parts(map_id, user, robot, topic):
    key = shared_key(map_id, user, robot, topic)
    assert parse_shared(key) == SharedKey(map_id, user, robot, topic)
    assert zenoh.KeyExpr(shared_by_all(map_id, topic)).intersects(zenoh.KeyExpr(key))


@given(names, names, names, topics)
def test_private_keys_never_look_shared(user, group, robot, topic):
    key = topic_key(user, group, robot, topic)
    assert not zenoh.KeyExpr("ppaas/map/**").intersects(zenoh.KeyExpr(key))


def test_a_traffic_node_addresses_one_robot():
    node = Scope("ann", "lab", TRAFFIC_NODE, "house")
    key = node.addressed_key("traffic/grants", "tb1")
    assert key == "ppaas/map/house/ann/_traffic/traffic/grants/tb1"
    assert parse_shared(key).topic_for("tb1") == "traffic/grants"
    node.check_write(key)


@given(names, names, names, names, topics)
def test_an_addressed_key_reaches_that_robot_alone(map_id, user, robot, other, topic):
    key = addressed_key(map_id, user, topic, robot)
    assert str(zenoh.KeyExpr(key)) == key
    assert parse_shared(key)[:3] == (map_id, user, TRAFFIC_NODE)
    assert parse_shared(key).topic_for(robot) == topic
    assert zenoh.KeyExpr(addressed_key(map_id, user, topic, other)).intersects(zenoh.KeyExpr(key)) == (robot == other)
    for pattern in (shared_by_all(map_id, topic), shared_by_user(map_id, user, topic)):
        assert not zenoh.KeyExpr(pattern).intersects(zenoh.KeyExpr(key)), "nobody hears it beside"


def test_topics_of_robots_and_coordinators_are_received_unchanged():
    for sharer in ("tb2", COORDINATOR):
        key = shared_key("house", "ann", sharer, "traffic/grants/tb1")
        assert parse_shared(key).topic_for("tb1") == "traffic/grants/tb1"


@pytest.mark.parametrize("sharer", ["tb1", COORDINATOR, "traffic"])
def test_only_a_traffic_node_may_address_a_robot(sharer):
    with pytest.raises(NotPermitted, match="only a traffic node may"):
        Scope("ann", "lab", sharer, "house").addressed_key("traffic/grants", "tb1")


def test_user_named_map_has_an_escaped_key():
    assert topic_key("map", "g", "r", "t") == "ppaas/%6Dap/g/r/t"


@pytest.mark.parametrize("key", ["", "ppaas/ann/g/r/t", "ppaas/map/house", "x/map/m/u/r/t", "ppaas/map/m//r/t"])
def test_a_key_that_is_not_shared_is_not_read_as_one(key):
    with pytest.raises(InvalidParameter):
        parse_shared(key)


@pytest.mark.parametrize("topic", ["*", "a/**", "a/../b", "..", "a$*", "a?x=1", "a#b"])
def test_wildcards_and_dots_in_a_topic_are_not_permitted(topic):
    with pytest.raises(NotPermitted):
        ANN.private_key(topic)


@pytest.mark.parametrize("topic", ["", "/", "a//b", "1a", "a b", "ä\n"])
def test_an_invalid_graph_name_is_not_a_topic(topic):
    with pytest.raises(InvalidParameter):
        ANN.private_key(topic)


@given(topics)
def test_a_container_may_read_and_write_its_private_keys(topic):
    for key in (ANN.private_key(topic), ANN.shared_key(topic)):
        ANN.check_write(key)
        ANN.check_read(key)


def test_container_may_read_but_not_write_shared_topics_of_others():
    key = shared_key("house", "bob", "tb9", "position")
    ANN.check_read(key)
    with pytest.raises(NotPermitted, match="may not write"):
        ANN.check_write(key)


FOREIGN = [
    "ppaas/bob/lab/tb1/scan",
    "ppaas/ann/office/tb1/scan",
    "ppaas/ann/lab/tb2/scan",
    "ppaas/ann/lab/tb1",
    "ppaas/ann/lab/tb11/scan",
    "ppaas/map/office/ann/tb1/position",
    "ppaas/ann/lab/tb1/*",
    "ppaas/ann/lab/tb1/**",
    "ppaas/*/lab/tb1/scan",
    "ppaas/ann/lab/tb1/../../bob/scan",
    "ppaas/ann/lab/tb1//scan",
    "ppaas/ann/lab/tb1/scan$*",
    "**",
    "",
    "@/router/x",
]


@pytest.mark.parametrize("key", FOREIGN)
def test_a_container_may_neither_read_nor_write_other_keys(key):
    with pytest.raises(NotPermitted):
        ANN.check_read(key)
    with pytest.raises(NotPermitted):
        ANN.check_write(key)


@given(names, names, names, names, topics)
def test_no_other_users_name_gives_access(user, group, robot, map_id, topic):
    other = Scope(user, group, robot, map_id)
    if user != ANN.user:
        with pytest.raises(NotPermitted):
            ANN.check_read(other.private_key(topic))
        with pytest.raises(NotPermitted):
            ANN.check_write(other.private_key(topic))
