"""Ids of requests: taken from clients if they are safe, made otherwise, and known to the log."""

import io
import json
import logging
import re

import httpx
import pytest
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send

from endpoints.http.front import REQUEST_ID, RequestIds
from ppaas.log_lines import JsonFormatter


async def logged(path: str, given: str | None = None) -> tuple[httpx.Response, dict[str, str]]:
    """Return the answer to a request, and the record that it writes to the log as JSON."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(JsonFormatter("e1"))
    logger = logging.Logger("served")
    logger.addHandler(handler)

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        logger.warning("served")
        await PlainTextResponse("served")(scope, receive, send)

    transport = httpx.ASGITransport(RequestIds(app))
    headers = {} if given is None else {REQUEST_ID: given}
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        answer = await client.get(path, headers=headers)
    return answer, json.loads(stream.getvalue())


@pytest.mark.parametrize("given", ["a", "7f3b-4.x_Y", "x" * 64])
async def test_a_safe_id_of_a_client_is_kept(given: str) -> None:
    answer, record = await logged("/v1/maps", given)
    assert (answer.headers[REQUEST_ID], record["request"]) == (given, given)


@pytest.mark.parametrize("given", [None, "", "x" * 65, "a b", 'a"b', "a/../b", "a\x1b[31m", "a\n"])
async def test_another_id_is_replaced(given: str | None) -> None:
    answer, record = await logged("/v1/maps", given)
    assert re.fullmatch("[0-9a-f]{16}", answer.headers[REQUEST_ID])
    assert record["request"] == answer.headers[REQUEST_ID]


async def test_two_requests_have_different_ids() -> None:
    first, second = [await logged("/v1/maps") for _ in range(2)]
    assert first[1]["request"] != second[1]["request"]


@pytest.mark.parametrize(
    ("path", "fields"),
    [
        ("/v1/maps/office", {}),
        ("/v1/robots", {}),
        ("/v1/robots/tb1", {"robot": "tb1"}),
        ("/v1/robots/ann:tb1/shares", {"robot": "ann:tb1"}),
        ("/v1/robots/tb1/goals/g7", {"robot": "tb1", "goal": "g7"}),
        ("/v1/robots/" + "x" * 130, {}),
    ],
)
async def test_the_robot_and_the_goal_of_a_path_are_known(path: str, fields: dict[str, str]) -> None:
    _, record = await logged(path)
    assert {name: record[name] for name in ("robot", "goal") if name in record} == fields


async def test_a_connection_of_another_kind_passes() -> None:
    seen = list[str]()

    async def app(scope: Scope, _receive: Receive, _send: Send) -> None:
        seen.append(scope["type"])

    await RequestIds(app)({"type": "websocket"}, None, None)  # type: ignore[arg-type]
    assert seen == ["websocket"]
