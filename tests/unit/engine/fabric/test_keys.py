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
)
from ppaas.errors import InvalidParameter, NotPermitted

names = st.text(st.characters(codec="utf-8"), min_size=1, max_size=12)
topics = st.from_regex(r"[a-z][a-z0-9_]{0,5}(/[a-z0-9_]{1,5}){0,2}", fullmatch=True)
ANN = Scope("ann", "tb1", "house")


def test_a_key_names_map_user_robot_and_topic():
    assert ANN.shared_key("position") == "ppaas/map/house/ann/tb1/position"


@given(names, names, names, topics)
def test_any_name_makes_a_unique_key_that_zenoh_accepts(map_id, user, robot, topic):
    key = shared_key(map_id, user, robot, topic)
    assert str(zenoh.KeyExpr(key)) == key
    assert len(key.split("/")) == 5 + len(topic.split("/"))
    assert not set("*$?#") & set(key)


@given(names, names)
def test_different_names_make_different_chunks(one, other):
    assert (chunk(one) == chunk(other)) == (one == other)


@given(names, names, names, topics)
def test_a_shared_key_is_parsed_into_its_parts(map_id, user, robot, topic):
    key = shared_key(map_id, user, robot, topic)
    assert parse_shared(key) == SharedKey(map_id, user, robot, topic)
    assert zenoh.KeyExpr(shared_by_all(map_id, topic)).intersects(zenoh.KeyExpr(key))


def test_a_traffic_node_addresses_one_robot():
    node = Scope("ann", TRAFFIC_NODE, "house")
    key = node.addressed_key("traffic/grants", "tb1")
    assert key == "ppaas/map/house/ann/_traffic/traffic/grants/tb1"
    assert parse_shared(key).topic_for("tb1") == "traffic/grants"


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
        Scope("ann", sharer, "house").addressed_key("traffic/grants", "tb1")


@pytest.mark.parametrize("key", ["", "ppaas/ann/g/r/t", "ppaas/map/house", "x/map/m/u/r/t", "ppaas/map/m//r/t"])
def test_a_key_that_is_not_shared_is_not_read_as_one(key):
    with pytest.raises(InvalidParameter):
        parse_shared(key)


@pytest.mark.parametrize("topic", ["*", "a/**", "a/../b", "..", "a$*", "a?x=1", "a#b"])
def test_wildcards_and_dots_in_a_topic_are_not_permitted(topic):
    with pytest.raises(NotPermitted):
        ANN.shared_key(topic)


@pytest.mark.parametrize("topic", ["", "/", "a//b", "1a", "a b", "ä\n"])
def test_an_invalid_graph_name_is_not_a_topic(topic):
    with pytest.raises(InvalidParameter):
        ANN.shared_key(topic)
