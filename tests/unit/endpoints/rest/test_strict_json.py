"""Strict JSON: what two parsers could read differently is rejected, and a body costs no more than its size.

Other members of the kind "a body that stops the loop": a key given twice among many (quadratic search), many small
objects and lists (garbage collection), deep nesting (recursion), long numbers, a body read before its caller is known,
and a list with a fault in each item (`tests/unit/endpoints/test_app_bodies.py`).
"""

import contextlib
import json
from typing import Any

import httpx
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.requests import Request

from endpoints.resources.services import Services
from endpoints.rest import strict_json
from endpoints.rest.strict_json import (
    HIDDEN,
    MAX_CONTAINERS,
    MAX_DEPTH,
    MAX_KEYS,
    MAX_NESTING,
    MAX_SHOWN,
    is_deeper,
    is_format,
    media_type_of,
    merge,
    parse,
    showable,
)
from ppaas.errors import MalformedMessage, MessageTooLarge, PPaaSError
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


def test_duplicate_keys_are_refused_at_any_depth() -> None:
    assert parse(b'{"a": {"b": 1}, "c": {"b": 1}}') == {"a": {"b": 1}, "c": {"b": 1}}
    with pytest.raises(MalformedMessage, match="'b' twice"):
        parse(b'{"a": [{"b": 1, "c": 2, "b": 1}]}')


class CountedName(str):
    """Name that counts how often it is hashed or compared."""

    used = 0

    def __hash__(self) -> int:
        CountedName.used += 1
        return super().__hash__()

    def __eq__(self, other: object) -> bool:
        CountedName.used += 1
        return super().__eq__(other)


def test_a_repeated_key_is_found_in_one_pass() -> None:
    names = [*map(str, range(MAX_KEYS - 1)), str(MAX_KEYS - 2)]
    CountedName.used = 0
    with pytest.raises(MalformedMessage, match="twice"):
        strict_json._object([(CountedName(name), 1) for name in names])
    assert CountedName.used < 10 * len(names)


@pytest.mark.parametrize(
    ("body", "fits"),
    [
        ("{" + ",".join(f'"{i}":1' for i in range(MAX_KEYS)) + "}", True),
        ("{" + ",".join(f'"{i}":1' for i in range(MAX_KEYS + 1)) + "}", False),
        ("[" + ",".join(["[]"] * (MAX_CONTAINERS - 1)) + "]", True),
        ("[" + ",".join(["[]"] * MAX_CONTAINERS) + "]", False),
        ("[" + ",".join(["{}"] * MAX_CONTAINERS) + "]", False),
    ],
    ids=["most keys", "too many keys", "most lists", "too many lists", "too many objects"],
)
def test_keys_and_containers_of_a_body_are_limited(body: str, fits: bool) -> None:
    if fits:
        assert parse(body.encode()) == json.loads(body)
    else:
        with pytest.raises(MessageTooLarge, match="at most"):
            parse(body.encode())


@pytest.mark.parametrize(("before", "after"), [("[", "]"), ('{"a":', "}"), ('[{"a":', "}]")])
def test_nesting_of_a_body_is_limited(before: str, after: str) -> None:
    count = MAX_DEPTH // (before.count("[") + before.count("{"))
    assert parse((before * count + "1" + after * count).encode())
    for depth in (count + 1, 900, 100_000):
        with pytest.raises(PPaaSError):
            parse((before * depth + "1" + after * depth).encode())


values = st.recursive(st.integers(), lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=2), inner))


BODIES = st.binary() | st.builds(
    lambda text, at, put: text[:at] + put + text[at:],
    values.map(lambda value: json.dumps(value).encode()),
    st.integers(0, 40),
    st.sampled_from([b"", b"\\", b'"', b"{", b"}", b"\xff", b"\0", b"\xed\xa0\x80", b"1e999", b"NaN", b"\\ud800"]),
)


@given(BODIES)
def test_any_bytes_are_read_or_refused(body: bytes) -> None:
    with contextlib.suppress(PPaaSError):
        parse(body)


# Media types of request bodies.


@pytest.mark.parametrize(
    ("header", "found"),
    [
        (b"application/json", "application/json"),
        (b" Application/JSON ; charset=utf-8", "application/json"),
        (b"", ""),
        (None, ""),
    ],
)
def test_the_media_type_has_no_parameters(header: bytes | None, found: str) -> None:
    headers = [] if header is None else [(b"content-type", header)]
    assert media_type_of(Request({"type": "http", "headers": headers})) == found


@pytest.mark.parametrize(
    ("media_type", "is_json"),
    [
        ("application/json", True),
        ("application/merge-patch+json", True),
        ("text/json", False),
        ("image/svg+json", False),
        ("application/jsonx", False),
        ("", False),
    ],
)
def test_a_format_is_named_alone_or_after_a_plus(media_type: str, is_json: bool) -> None:
    assert is_format(media_type, "json") == is_json


# JSON merge patch: the examples of RFC 7396, appendix A.


@pytest.mark.parametrize(
    ("target", "patch", "result"),
    [
        ({"a": "b"}, {"a": "c"}, {"a": "c"}),
        ({"a": "b"}, {"b": "c"}, {"a": "b", "b": "c"}),
        ({"a": "b"}, {"a": None}, {}),
        ({"a": "b", "b": "c"}, {"a": None}, {"b": "c"}),
        ({"a": ["b"]}, {"a": "c"}, {"a": "c"}),
        ({"a": "c"}, {"a": ["b"]}, {"a": ["b"]}),
        ({"a": {"b": "c"}}, {"a": {"b": "d", "c": None}}, {"a": {"b": "d"}}),
        ({"a": [{"b": "c"}]}, {"a": [1]}, {"a": [1]}),
        (["a", "b"], ["c", "d"], ["c", "d"]),
        ({"a": "b"}, ["c"], ["c"]),
        ({"a": "foo"}, None, None),
        ({"a": "foo"}, "bar", "bar"),
        ({"e": None}, {"a": 1}, {"e": None, "a": 1}),
        ([1, 2], {"a": "b", "c": None}, {"a": "b"}),
        ({}, {"a": {"bb": {"ccc": None}}}, {"a": {"bb": {}}}),
    ],
)
def test_examples_of_rfc_7396(target: Any, patch: Any, result: Any) -> None:
    assert merge(target, patch) == result


JSON = {"Content-Type": "application/json"}


def depth_of(value: Any) -> int:
    children = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if children is None else 1 + max(map(depth_of, children), default=0)


# Values that are nested too deeply are refused before they are stored, and stored ones do not break a list.
#
# The kind: input that is accepted and cannot be shown again. Its members: objects, lists and both, in the parameters
# and properties of robots and the parameters of plans, by PUT and by PATCH; text that is not Unicode; numbers that
# are not finite or too large.


@given(values)
def test_the_depth_of_a_value_is_measured(value: Any) -> None:
    depth = depth_of(value)
    assert not is_deeper(value, depth)
    assert depth == 0 or is_deeper(value, depth - 1)


def nested(before: str, after: str, count: int) -> str:
    return before * count + "1" + after * count


TOO_DEEP = [
    nested('{"a":', "}", MAX_NESTING + 1),
    nested('{"a":', "}", 300),
    '{"a":' + nested("[", "]", 300) + "}",
    '{"a":' + nested('[{"a":', "}]", 100) + "}",
]


@pytest.mark.parametrize("value", TOO_DEEP, ids=["a level more", "objects", "lists", "both"])
@pytest.mark.parametrize("field", ["parameters", "properties"])
async def test_a_robot_with_too_deep_values_is_refused_and_not_stored(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, field: str, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    answer = await client.put("/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","{field}":{value}}}')
    assert f"at most {MAX_NESTING}" in problem_of(answer, 422, "invalid-request")["detail"]
    most = nested('{"a":', "}", MAX_NESTING)
    answer = await client.put("/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","{field}":{most}}}')
    assert answer.status_code == 201
    answer = await client.patch("/v1/robots/tb1", headers=header | JSON, content=f'{{"{field}":{value}}}')
    problem_of(answer, 422, "invalid-request")
    [listed] = (await client.get("/v1/robots", headers=header)).json()["items"]
    assert not is_deeper(listed[field], MAX_NESTING)


@pytest.mark.parametrize("value", TOO_DEEP)
async def test_a_plan_with_too_deep_parameters_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    plan = f'{{"map":"house","planner":"dijkstra","poses":[[0,0,0,0,0,0,1]],"parameters":{value}}}'
    problem_of(await client.put("/v1/plans/p1", headers=header | JSON, content=plan), 422, "invalid-request")
    problem_of(await client.get("/v1/plans/p1", headers=header), 404, "not-found")


@pytest.mark.parametrize("value", [r'"\ud800"', "9" * 400, "NaN", "1e400"])
async def test_values_that_cannot_be_written_again_are_refused_and_not_stored(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, value: str
) -> None:
    header = await log_in("ann")
    await publish(header)
    answer = await client.put(
        "/v1/robots/tb1", headers=header | JSON, content=f'{{"map":"house","parameters":{{"a":{value}}}}}'
    )
    assert answer.status_code in (400, 422)
    assert (await client.get("/v1/robots", headers=header)).json()["items"] == []


async def test_a_stored_robot_that_cannot_be_shown_does_not_break_the_list(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    header = await log_in("ann")
    await publish(header)
    for name in ("deep", "good"):
        await client.put(f"/v1/robots/{name}", headers=header, json={"map": "house", "parameters": {"a": 1}})
    deep: dict[str, Any] = {}
    for _ in range(300):
        deep = {"a": deep}
    services.store.put_robot(msgspec.structs.replace(services.store.robot("ann", "deep"), parameters=deep))
    items = (await client.get("/v1/robots", headers=header)).json()["items"]
    assert [(item["id"], item["parameters"]) for item in items] == [("deep", HIDDEN), ("good", {"a": 1})]
    assert (await client.get("/v1/robots/deep", headers=header)).json()["parameters"] == HIDDEN


def test_what_can_be_shown_is_shown_unchanged() -> None:
    value: list[Any] = []
    for _ in range(MAX_SHOWN - 1):
        value = [value]
    assert showable(value) is value
    assert showable([value]) == HIDDEN
