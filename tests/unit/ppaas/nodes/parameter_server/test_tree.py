"""Parameter tree: nodes' parameters are read-only, others are stored, and invalid ones change nothing."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter, NotFound, QuotaExceeded
from ppaas.nodes.parameter_server.tree import MAX_DEPTH, MAX_FREE, MAX_FREE_BYTES, ParameterTree, path_of, read_value

OWN = {
    "move_base": {"controller_frequency": 10.0, "recovery_behaviors": [{"name": "wait", "type": "wait"}], "on": True},
    "dwa": {"vx_samples": 8},
}
NAMES = st.from_regex(r"[a-z]{1,2}", fullmatch=True)
LEAVES = st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False, allow_infinity=False) | st.text()
VALUES = st.recursive(LEAVES | st.lists(LEAVES), lambda inner: st.dictionaries(NAMES, inner, max_size=3), max_leaves=8)


@pytest.fixture
def tree() -> ParameterTree:
    return ParameterTree(OWN)


def test_node_parameters_are_read_by_name_and_namespace(tree):
    assert tree.names() == [
        "/dwa/vx_samples", "/move_base/controller_frequency", "/move_base/on", "/move_base/recovery_behaviors",
    ]  # fmt: skip
    assert tree.get("/move_base/controller_frequency") == 10.0
    assert tree.get("move_base") == tree.get("/move_base/") == OWN["move_base"]
    assert tree.get("/move_base:on") is True, "spelled as by rosapi of ROS 2"
    assert tree.get("/") == OWN
    assert (tree.has("/dwa"), tree.has("/dwa/vx_samples"), tree.has("/dwa/vx")) == (True, True, False)
    assert (tree.search("dwa/vx_samples"), tree.search("nothing")) == ("/dwa/vx_samples", "")


@given(st.dictionaries(NAMES, VALUES, max_size=4))
def test_free_parameters_round_trip_and_can_be_restored(given_values):
    tree = ParameterTree(OWN)
    for name, value in given_values.items():
        tree.set(f"/free/{name}", read_value(json.dumps(value)))
    again = ParameterTree(OWN)
    again.restore(tree.free())
    assert again.names() == tree.names()
    for name, value in given_values.items():
        for kept in (tree, again):
            assert json.dumps(kept.get(f"free/{name}"), sort_keys=True) == json.dumps(value, sort_keys=True)


def test_setting_a_name_replaces_its_namespace_or_parent_value(tree):
    tree.set("/a", {"b": {"c": 1}, "d": 2})
    assert tree.get("/a/b/c") == 1
    tree.set("/a/b", 3)
    assert tree.get("/a") == {"b": 3, "d": 2}
    tree.set("/a/b/c/d", 4)
    assert tree.get("/a") == {"b": {"c": {"d": 4}}, "d": 2}
    tree.set("/a", 5)
    assert tree.get("/a") == 5
    assert "/a" in tree.names()


def test_delete_removes_the_parameter_only(tree):
    tree.set("/a", {"b": 1, "c": {"d": 2}})
    tree.delete("/a/c")
    assert tree.get("/a") == {"b": 1}
    tree.delete("/a")
    with pytest.raises(NotFound, match="unknown parameter '/a'"):
        tree.delete("/a")
    assert tree.get("/") == OWN


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("/move_base/controller_frequency", 20.0, "/move_base/controller_frequency is read only when .* robot's file"),
        ("/move_base", {"controller_frequency": 20.0}, "is read only when"),
        ("/move_base", 5, "is read only when"),
        ("/move_base/recovery_behaviors/x", 5, "is read only when"),
        ("/move_base/controler_frequency", 20.0, "no parameter /move_base/controler.*known: .*controller_frequency"),
        ("/", 5, "'/' is not a parameter"),
        ("", {}, "'/' is not a parameter"),
        ("/a", {"b/c": 1}, "'b/c' in /a"),
        ("/a", {"": 1}, "'' in /a"),
        ("/a", {"ü": 1}, "name"),
        ("/a b", 1, "invalid parameter name"),
        ("//a", 1, "invalid parameter name"),
        ("/" + "a" * 300, 1, "invalid parameter name"),
        ("/a" * (MAX_DEPTH + 1), 1, "at most"),
    ],
)
def test_invalid_set_is_refused_and_changes_nothing(tree, name, value, text):
    tree.set("/a", 1)
    before = tree.free()
    with pytest.raises(InvalidParameter, match=text):
        tree.set(name, value)
    assert tree.free() == before
    assert tree.get("/move_base") == OWN["move_base"]


def test_setting_a_nodes_parameter_to_its_value_is_allowed(tree):
    tree.set("/move_base", {"controller_frequency": 10, "on": True})
    tree.set("/", {**OWN, "mine": 1})
    assert (tree.get("/move_base"), tree.get("/mine")) == (OWN["move_base"], 1)


@pytest.mark.parametrize("name", ["/move_base", "/move_base/on", "/"])
def test_node_parameters_cannot_be_deleted(tree, name):
    with pytest.raises(InvalidParameter, match="is read only when"):
        tree.delete(name)


def test_number_and_size_of_free_parameters_are_limited(tree):
    for number in range(MAX_FREE):
        tree.set(f"/free/p{number}", 0)
    with pytest.raises(QuotaExceeded, match=f"at most {MAX_FREE}"):
        tree.set("/free/more", 0)
    tree.set("/free", "x" * (MAX_FREE_BYTES - 100))
    with pytest.raises(QuotaExceeded):
        tree.set("/more", "x" * 200)


@pytest.mark.parametrize(
    "text",
    [
        "NaN", "Infinity", "-Infinity", "1e999", "null", "[1, null]", '{"a": NaN}', str(2**63), "1" * 5000,
        "", "{", "'a'",
        "[" * 20 + "]" * 20, "[" * 10000 + "]" * 10000, '{"a":' * 50 + "1" + "}" * 50, '"' + "x" * MAX_FREE_BYTES + '"',
    ],
)  # fmt: skip
def test_invalid_value_is_refused(text):
    with pytest.raises(InvalidParameter):
        read_value(text)


@pytest.mark.parametrize(
    ("text", "value"), [("1", 1), ("1.0", 1.0), ("true", True), ('"1"', "1"), ("[1, [2.5]]", [1, [2.5]])]
)
def test_values_keep_their_types(text, value):
    read = read_value(text)
    assert (read, type(read)) == (value, type(value))


@given(st.text(max_size=20))
def test_any_text_is_a_valid_name_or_refused(text):
    try:
        path = path_of(text)
    except InvalidParameter:
        return
    assert path_of("/" + "/".join(path)) == path
