"""The fast path takes only requests that the route takes, and understands them as the route does."""

import json
from typing import Any

import httpx
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from starlette.types import Message

from endpoints.rest.plans import fast_path
from endpoints.rest.plans.fleet_plans import FleetFile, FleetPlanAnswer
from endpoints.rest.plans.schemas import CostFile, CostMatrixAnswer, NewPlanAnswer, PlanFile
from endpoints.rest.strict_json import parse
from engine.control.planning.requests import CostAnswer, CostRequest, FleetAnswer, FleetRequest
from ppaas.plans.path_service import PathAnswer, PathRequest
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
        "queue": st.booleans() | anything,
        "labels": st.dictionaries(st.sampled_from(["zone", "no name", "a" * 65, "rack\n"]), anything | st.just("a")),
        "parameters": st.dictionaries(st.sampled_from(["allow_unknown", "robot_radius"]), anything) | anything,
        "more": anything,
    },
)


async def read(body: bytes) -> PathRequest | None:
    async def receive() -> Message:
        return {"type": "http.request", "body": body, "more_body": False}

    return await fast_path._read_request(receive, [])


@given(files)
async def test_the_fast_path_reads_a_request_as_the_route_does(file: dict[str, Any]) -> None:
    body = json.dumps(file).encode()
    taken = await read(body)
    try:
        route = msgspec.convert(PlanFile.model_validate(parse(body)).model_dump(exclude_none=True), PathRequest)
    except ValidationError:
        assert taken is None
        return
    if taken is not None:
        assert taken == route
        assert [type(value) for value in msgspec.structs.astuple(taken)] == list(
            map(type, msgspec.structs.astuple(route))
        )


@pytest.mark.parametrize(
    "pair",
    [
        (PlanFile, PathRequest),
        (CostFile, CostRequest),
        (FleetFile, FleetRequest),
        (NewPlanAnswer, PathAnswer),
        (CostMatrixAnswer, CostAnswer),
        (FleetPlanAnswer, FleetAnswer),
    ],
    ids=lambda pair: pair[1].__name__,
)
def test_openapi_describes_the_fields_of_requests_and_answers(pair: tuple[Any, Any]) -> None:
    schema, struct = pair
    assert set(schema.model_fields) == set(struct.__struct_fields__)
    for field in msgspec.structs.fields(struct):
        described = schema.model_fields[field.name]
        if struct is PathAnswer:  # a planner server leaves out what REST adds
            assert described.is_required()
            continue
        assert described.is_required() == field.required
        if not field.required and field.name != "timeout":  # null for the default of the service
            default = field.default if field.default is not msgspec.NODEFAULT else field.default_factory()
            assert described.default == default


@pytest.mark.parametrize(
    "body",
    [
        b'{"start": [1, 2], "goal": [3, 4], "start": [5, 6]}',
        b'{"start": [1, 2], "goal": [3, 4], "st\\u0061rt": [5, 6]}',
        json.dumps(POSE).encode("utf-16"),
        b'{"start": [1, 2], "goal": [3, 4], "labels": {"a": "b", "a": "c"}}',
        b'{"start": [1, 2], "goal": [3, 4], "parameters": {"smooth": true, "smooth": false}}',
        b'\xef\xbb\xbf{"start": [1, 2], "goal": [3, 4]}',
        b'{"start": [1, 2], "goal": [3, 1e999]}',
        b'{"start": [1, 2], "goal": [3, NaN]}',
        b"[" * 100_000,
        b"\xff",
        b"",
    ],
)
async def test_unusual_requests_are_left_to_the_route(body: bytes) -> None:
    assert await read(body) is None


async def test_the_fast_path_reads_a_valid_request() -> None:
    taken = await read(json.dumps(POSE | {"timeout": 1, "reuse": False}).encode())
    assert taken == PathRequest((1.0, 2.0), (3.0, 4.0, 0.5), timeout=1.0, reuse=False)


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"content-type": "application/json; charset=utf-8"},
        {"authorization": "bearer TOKEN"},
        {"authorization": "Basic dXNlcg=="},
    ],
)
async def test_tokens_and_content_types_are_read_as_the_route_reads_them(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, headers: dict[str, str]
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    token = ann["Authorization"].partition(" ")[2]
    sent_headers = {"content-type": "application/json", "authorization": f"Bearer {token}"} | headers
    sent_headers = {name: value.replace("TOKEN", token) for name, value in sent_headers.items()}
    answer = await client.post("/v1/maps/house/plans", headers=sent_headers, content=json.dumps(POSE))
    assert answer.status_code == (401 if "Basic" in sent_headers["authorization"] else 201), answer.text
