"""Traces of requests: their names, their clients, and what their answers say of them."""

from collections.abc import Iterator

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route

from endpoints.http.front import ApplicationFront
from endpoints.http.front_settings import FrontSettings
from ppaas.tracing.spans import SpanRecord, traceparent
from tests.support.recorded_spans import recorded_spans

TRACE, CLIENT = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"


async def _answer(request: Request) -> PlainTextResponse:
    return PlainTextResponse(traceparent(), int(request.query_params.get("status", "200")))


async def _fail(_request: Request) -> PlainTextResponse:
    raise ZeroDivisionError("a fault")


ROUTES = [
    Route("/v1/robots/{robot_id}/goals", _answer, methods=["POST"]),
    Route("/v1/maps/{map_id}/plans", _answer, methods=["POST"]),
    Route("/v1/health", _answer),
    Route("/v1/fault", _fail),
    Route("/dashboard", _answer),
]


@pytest.fixture
def recorded() -> Iterator[list[SpanRecord]]:
    with recorded_spans() as spans:
        yield spans


def client() -> httpx.AsyncClient:
    app = ApplicationFront(Starlette(routes=ROUTES), FrontSettings(), "/v1")
    return httpx.AsyncClient(transport=httpx.ASGITransport(app, raise_app_exceptions=False), base_url="http://cloud")


async def test_a_request_is_a_span_in_the_trace_of_its_client(recorded: list[SpanRecord]) -> None:
    sent = {"traceparent": f"00-{TRACE}-{CLIENT}-01", "X-Request-ID": "r7"}
    async with client() as cloud:
        inside = (await cloud.post("/v1/robots/tb1/goals", headers=sent)).text
    [span] = recorded
    assert inside == f"00-{TRACE}-{span.id}-01"
    assert (span.name, span.kind, span.parent) == ("POST /v1/robots/{robot_id}/goals", "server", CLIENT)
    assert span.attributes == {
        "http.request.method": "POST",
        "http.route": "/v1/robots/{robot_id}/goals",
        "http.response.status_code": 200,
        "ppaas.request": "r7",
        "ppaas.robot": "tb1",
    }


async def test_a_path_request_has_a_route_before_it_is_routed(recorded: list[SpanRecord]) -> None:
    async with client() as cloud:
        await cloud.post("/v1/maps/office/plans")
    [span] = recorded
    assert (span.name, span.parent) == ("POST /v1/maps/{map_id}/plans", "")


@pytest.mark.parametrize("headers", [[("traceparent", "nonsense")], [("traceparent", f"00-{TRACE}-{CLIENT}-01")] * 2])
async def test_a_header_that_is_no_trace_is_ignored(recorded: list[SpanRecord], headers: list[tuple[str, str]]) -> None:
    async with client() as cloud:
        assert (await cloud.post("/v1/maps/office/plans", headers=headers)).status_code == 200
    [span] = recorded
    assert span.trace != TRACE


@pytest.mark.parametrize(("status", "error"), [(404, ""), (503, "503")])
async def test_faults_of_the_cloud_alone_are_errors(recorded: list[SpanRecord], status: int, error: str) -> None:
    async with client() as cloud:
        await cloud.post(f"/v1/maps/office/plans?status={status}")
    [span] = recorded
    assert (span.attributes["http.response.status_code"], span.error) == (status, error)


async def test_an_exception_ends_its_span(recorded: list[SpanRecord]) -> None:
    async with client() as cloud:
        await cloud.get("/v1/fault")
    [span] = recorded
    assert (span.name, span.error, span.message) == ("GET /v1/fault", "ZeroDivisionError", "a fault")


async def test_an_unknown_path_has_no_name_of_its_own(recorded: list[SpanRecord]) -> None:
    async with client() as cloud:
        await cloud.get("/v1/no/such/path")
    [span] = recorded
    assert span.name == "GET"


@pytest.mark.parametrize("path", ["/v1/health", "/dashboard"])
async def test_probes_and_pages_begin_no_trace(recorded: list[SpanRecord], path: str) -> None:
    async with client() as cloud:
        assert (await cloud.get(path)).text == ""
    assert not recorded


async def test_without_traces_the_header_is_ignored() -> None:
    async with client() as cloud:
        answer = await cloud.post("/v1/maps/office/plans", headers={"traceparent": f"00-{TRACE}-{CLIENT}-01"})
    assert answer.text == ""
