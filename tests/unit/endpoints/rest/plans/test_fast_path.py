"""Requests for paths that are served before FastAPI looks at them are those that it would serve, in the same way."""

import json
from typing import Any

import httpx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.types import Message

from endpoints.rest.plans import fast_path
from endpoints.rest.plans.schemas import PlanFile
from endpoints.rest.strict_json import parse
from tests.unit.endpoints.conftest import LogIn, Publish

POSE = {"start": [1.0, 2.0], "goal": [3, 4, 0.5]}

numbers = st.integers(-5, 5) | st.floats(-2e9, 2e9) | st.sampled_from([float("nan"), float("inf"), -0.0, 1e9, -1e9])
anything = numbers | st.booleans() | st.none() | st.text(max_size=3) | st.lists(numbers, max_size=4)
poses = st.lists(numbers, min_size=1, max_size=4) | anything
files = st.fixed_dictionaries(
    {"start": poses, "goal": poses},
    optional={
        "planner": st.sampled_from(["dijkstra", "navfn/NavfnROS", "no name", "", '"start"']) | anything,
        "tolerance": numbers | anything,
        "timeout": numbers | anything,
        "reuse": st.booleans() | anything,
        "more": anything,
    },
)


async def asked(body: bytes) -> Any:
    async def receive() -> Message:
        return {"type": "http.request", "body": body, "more_body": False}

    return await fast_path._asked(receive, [])


@settings(max_examples=500)
@given(files)
async def test_what_is_taken_is_what_the_route_takes(file: dict[str, Any]) -> None:
    body = json.dumps(file).encode()
    taken = await asked(body)
    if taken is not None:
        route = PlanFile.model_validate(parse(body))
        for name in taken.__struct_fields__:
            assert getattr(taken, name) == getattr(route, name)
            assert type(getattr(taken, name)) is type(getattr(route, name))
        assert route.model_fields_set <= set(taken.__struct_fields__)


@pytest.mark.parametrize(
    "body",
    [
        b'{"start": [1, 2], "goal": [3, 4], "start": [5, 6]}',
        b'{"start": [1, 2], "goal": [3, 4], "st\\u0061rt": [5, 6]}',
        json.dumps(POSE).encode("utf-16"),
        b'\xef\xbb\xbf{"start": [1, 2], "goal": [3, 4]}',
        b'{"start": [1, 2], "goal": [3, 1e999]}',
        b'{"start": [1, 2], "goal": [3, NaN]}',
        b"[" * 100_000,
        b"\xff",
        b"",
    ],
)
async def test_what_is_unusual_is_left_to_the_route(body: bytes) -> None:
    assert await asked(body) is None


async def test_a_request_that_is_right_is_taken() -> None:
    taken = await asked(json.dumps(POSE | {"timeout": 1, "reuse": False}).encode())
    assert (taken.start, taken.goal, taken.timeout, taken.reuse) == ([1.0, 2.0], [3.0, 4.0, 0.5], 1.0, False)


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"content-type": "application/json; charset=utf-8"},
        {"authorization": "bearer TOKEN"},
        {"authorization": "Basic dXNlcg=="},
    ],
)
async def test_tokens_and_types_are_read_as_the_route_reads_them(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, headers: dict[str, str]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    token = ann["Authorization"].partition(" ")[2]
    told = {"content-type": "application/json", "authorization": f"Bearer {token}"} | headers
    told = {name: value.replace("TOKEN", token) for name, value in told.items()}
    answer = await client.post("/v1/maps/house/plans", headers=told, content=json.dumps(POSE))
    assert answer.status_code == (401 if "Basic" in told["authorization"] else 201), answer.text
