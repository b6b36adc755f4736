"""No body is read or parsed before its caller is known, and none blocks other requests.

The kind: work that a stranger causes before authentication. Its members: bodies of each route with JSON, the fast path
of path requests, a body without an end, and logins, which need no token and are therefore small.
"""

import json
import re
from collections.abc import AsyncIterator

import httpx
import pytest
from fastapi.routing import APIRoute

from endpoints.app import LOGINS, PREFIX, RESOURCES, description
from endpoints.resources.services import RequestLimits
from endpoints.rest.dependencies import any_user
from endpoints.rest.strict_json import StrictRoute, _depends_on
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

JSON = {"Content-Type": "application/json"}
ROUTES = [route for resource in RESOURCES for route in resource.router.routes if isinstance(route, APIRoute)]


def test_every_route_with_a_body_authenticates_first_except_logins() -> None:
    with_body = [route for route in ROUTES if route.body_field is not None]
    assert len(with_body) > 10
    assert all(isinstance(route, StrictRoute) for route in with_body)
    open_to_all = [route.path for route in with_body if not _depends_on(route.dependant, any_user)]
    assert open_to_all == ["/tokens", "/oidc/codes", "/oidc/device-tokens", "/oidc/access-tokens"]
    assert set(open_to_all) <= set(LOGINS)


WITH_BODY = [(method, PREFIX + route.path) for route in ROUTES if route.body_field for method in route.methods or ()]


@pytest.mark.parametrize(("method", "path"), [pair for pair in WITH_BODY if pair[1].removeprefix(PREFIX) not in LOGINS])
@pytest.mark.parametrize("token", [{}, {"Authorization": "Bearer nobody's"}], ids=["no token", "unknown token"])
async def test_the_body_of_a_stranger_is_not_read(
    client: httpx.AsyncClient, method: str, path: str, token: dict[str, str]
) -> None:
    read = []

    async def body() -> AsyncIterator[bytes]:
        for block in (b"{", b'"start": [0, 0]'):
            read.append(block)
            yield block

    url = re.sub(r"{\w+}", "house", path)
    answer = await client.request(method, url, headers=token | JSON, content=body())
    problem_of(answer, 401, "not-authenticated")
    assert read == []


async def test_a_login_with_a_long_body_is_refused(client: httpx.AsyncClient) -> None:
    limit = RequestLimits().max_login
    longest = {"user": "\U0001f916" * 64, "password": "\U0001f916" * 1024}
    assert len(json.dumps(longest)) < limit
    problem_of(await client.post("/v1/tokens", headers=JSON, json=longest), 401, "not-authenticated")
    keys = "{" + ",".join(f'"{i:x}":1' for i in range(20_000)) + ',"1":2}'
    answer = await client.post("/v1/tokens", headers=JSON, content=keys)
    assert str(limit) in problem_of(answer, 413, "message-too-large")["detail"]


@pytest.mark.parametrize("path", LOGINS)
async def test_the_body_of_each_kind_of_login_is_small(client: httpx.AsyncClient, path: str) -> None:
    body = b'{"code": "' + b"x" * RequestLimits().max_login + b'"}'
    problem_of(await client.post(f"{PREFIX}{path}", headers=JSON, content=body), 413, "message-too-large")


async def test_a_list_with_many_faults_is_refused_for_its_first_item(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    header = await log_in("ann")
    await publish(header)
    faults = [[0, "x", 0, 0, 0, 0, 1]] * 1000
    answer = await client.put(
        "/v1/plans/p1", headers=header, json={"map": "house", "planner": "dijkstra", "poses": faults}
    )
    [fault] = problem_of(answer, 422, "invalid-request")["errors"]
    assert fault["where"] == ["body", "poses", "0", "1"]
    answer = await client.post(
        "/v1/maps/house/cost_matrix", headers=header, json={"starts": [["x", 0]] * 900, "goals": [["x", 0]] * 900}
    )
    assert len(problem_of(answer, 422, "invalid-request")["errors"]) == 2


# The description of the REST service can be had without a cloud.


async def test_it_is_the_one_that_a_cloud_serves(client: httpx.AsyncClient) -> None:
    assert (await client.get("/openapi.json")).json() == description()
