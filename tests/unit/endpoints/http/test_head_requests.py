"""HEAD is answered wherever GET is, with the same head and no body.

Its members: operations of REST, pages, redirects, files of the dashboard, problems, and answers that are sent in parts,
which are not read to their end.
"""

import asyncio
from collections.abc import AsyncIterator

import httpx
import pytest
from starlette.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from endpoints.http.head_requests import HeadRequests
from endpoints.http.http_protocol import DirectHttp
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.serving import serve
from tests.support.waiting import PATIENCE
from tests.unit.endpoints.conftest import LogIn, Publish

HTML = {"Accept": "text/html"}


@pytest.mark.parametrize(
    "path",
    [
        "/v1/health",
        "/v1/maps",
        "/v1/maps/house",
        "/v1/maps/house/image",
        "/v1/maps/house/cells",
        "/v1/maps/none",
        "/v1/nothing",
        "/v1/robots",
        "/docs",
        "/openapi.json",
        "/",
        "/dashboard",
        "/dashboard/",
        "/dashboard/nothing",
    ],
)
async def test_head_is_answered_like_get(client: httpx.AsyncClient, log_in: LogIn, publish: Publish, path: str) -> None:
    header = await log_in("ann")
    await publish(header)
    got = await client.get(path, headers=header | HTML)
    head = await client.head(path, headers=header | HTML)
    assert head.status_code == got.status_code
    changing = {"content-length"} if path == "/v1/health" else set()  # it has figures of this moment
    assert {name: head.headers[name] for name in head.headers.keys() - changing} == {
        name: got.headers[name] for name in got.headers.keys() - changing
    }
    assert head.content == b""


async def test_head_needs_a_token_where_get_does_and_is_no_way_around_methods(client: httpx.AsyncClient) -> None:
    assert (await client.head("/v1/robots")).status_code == 401
    answer = await client.head("/v1/users/me/nothing")
    assert answer.status_code == 404
    answer = await client.head("/v1/maps/house/cost_matrix")
    assert (answer.status_code, answer.headers["allow"]) == (405, "POST")
    problem_of(await client.delete("/v1/health"), 405, "method-not-allowed")
    assert (await client.delete("/v1/health")).headers["allow"] == "GET, HEAD"


async def test_a_long_answer_is_not_read_to_its_end() -> None:
    read = []

    async def parts() -> AsyncIterator[bytes]:
        for number in range(1000):
            read.append(number)
            yield b"x" * 1000
            await asyncio.sleep(0.001)

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        assert scope["method"] in ("GET", "POST")
        response = StreamingResponse(parts()) if scope["path"] == "/parts" else Response("whole")
        await response(scope, receive, send)

    async with (
        serve(HeadRequests(app), http=DirectHttp) as port,
        httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client,
    ):
        for _ in range(3):
            head = await client.head("/parts")
            assert (head.status_code, head.content) == (200, b"")
        assert len(read) < 1000
        assert (await client.head("/")).headers["content-length"] == "5"
        assert (await client.get("/")).text == "whole"
        assert (await client.post("/")).text == "whole"
