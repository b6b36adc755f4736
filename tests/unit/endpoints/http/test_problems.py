"""All errors become problem responses."""

import asyncio
import json
import logging
import re
import threading
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from fastapi.openapi.utils import get_openapi

import ppaas.recoveries  # noqa: F401 - it has an error of its own
from endpoints.app import create_app
from endpoints.http.problems import MAX_ADDRESSES, PER_SECOND, QUEUE_RETRY, STATUS, RefusalLog, problem_response
from endpoints.resources.services import Services
from endpoints.rest import openapi
from endpoints.rest.schemas import Problem
from endpoints.rest.users import oidc
from ppaas import errors
from ppaas.clock import ManualClock
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


def kinds(base: type[errors.PPaaSError] = errors.PPaaSError) -> Iterator[type[errors.PPaaSError]]:
    yield base
    for kind in base.__subclasses__():
        yield from kinds(kind)


def test_a_queued_request_is_answered_with_202() -> None:
    response = problem_response(errors.Queued(3))
    assert (response.status_code, response.media_type) == (202, "application/json")
    assert json.loads(bytes(response.body))["position"] == 3
    assert response.headers["retry-after"] == str(QUEUE_RETRY)


@pytest.mark.parametrize("kind", [kind for kind in kinds() if kind is not errors.Queued])
def test_every_error_class_becomes_a_problem(kind: type[errors.PPaaSError]) -> None:
    arguments: dict[type[errors.PPaaSError], tuple[Any, ...]] = {
        errors.NotFound: ("map", "house"),
        errors.InvalidRobot: ([errors.RobotFault("map", "is missing")],),
    }
    error = kind(*arguments.get(kind, ("do this",)))
    response = problem_response(error)
    answer = httpx.Response(response.status_code, headers=dict(response.headers), content=bytes(response.body))
    body = problem_of(answer, response.status_code, kind.slug)
    assert body["detail"] == str(error)
    assert 400 <= response.status_code < 600


def test_the_status_table_contains_only_known_errors() -> None:
    assert set(STATUS) <= set(kinds())


async def test_an_unknown_path_is_a_not_found_problem(client: httpx.AsyncClient) -> None:
    problem_of(await client.get("/v1/nothing"), 404, "not-found")


async def test_a_wrong_method_is_a_problem_that_lists_the_allowed_ones(client: httpx.AsyncClient) -> None:
    answer = await client.put("/v1/tokens")
    problem_of(answer, 405, "method-not-allowed")
    assert set(answer.headers["allow"].split(", ")) == {"GET", "HEAD", "POST"}


async def test_the_methods_of_all_operations_are_listed(services: Services, client: httpx.AsyncClient) -> None:
    for path, methods in create_app(services).openapi()["paths"].items():
        answer = await client.request("TRACE", re.sub(r"{\w+}", "a", path))
        assert answer.status_code == 405
        assert set(answer.headers["allow"].lower().split(", ")) - {"head"} >= set(methods)


async def test_a_wrong_method_does_not_make_the_description_of_the_service(services: Services) -> None:
    app = create_app(services)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://cloud") as client:
        assert (await client.put("/v1/tokens")).status_code == 405
    assert app.openapi_schema is None, "it takes more than a second"


async def test_the_description_of_the_service_is_made_beside_the_event_loop(
    services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    made_by: list[threading.Thread] = []

    def describe(**options: Any) -> dict[str, Any]:
        made_by.append(threading.current_thread())
        return get_openapi(**options)

    monkeypatch.setattr(openapi, "get_openapi", describe)
    transport = httpx.ASGITransport(create_app(services))
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as client:
        answers = await asyncio.gather(*(client.get("/openapi.json") for _ in range(3)))
    assert [answer.status_code for answer in answers] == [200, 200, 200]
    assert len(made_by) == 1, "others wait for it, without threads of their own"
    assert made_by[0] is not threading.main_thread()


async def test_unexpected_errors_are_logged_once_and_not_disclosed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud, caplog: pytest.LogCaptureFixture
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    cloud.error = RuntimeError("the password of the database is hunter2")
    with caplog.at_level(logging.WARNING):
        body = {"start": [0, 0], "goal": [1, 1]}
        answer = await client.post("/v1/maps/house/plans", headers=ann, json=body)
    problem_of(answer, 500, "internal-error")
    assert "hunter2" not in answer.text
    records = [record for record in caplog.records if record.exc_info]
    assert len(records) == 1
    assert "POST /v1/maps/house/plans" in records[0].getMessage()


async def test_an_upload_that_its_client_aborts_is_no_failure_of_the_cloud(
    services: Services, log_in: LogIn, caplog: pytest.LogCaptureFixture
) -> None:
    form = b'--edge\r\nContent-Disposition: form-data; name="id"\r\n\r\nhouse'
    received = iter(({"type": "http.request", "body": form, "more_body": True}, {"type": "http.disconnect"}))
    sent: list[Any] = []

    async def receive() -> Any:
        return next(received)

    async def send(message: Any) -> None:
        sent.append(message)

    headers = {
        "Authorization": (await log_in("ann"))["Authorization"],
        "Content-Type": "multipart/form-data; boundary=edge",
    }
    scope = {
        "type": "http", "method": "POST", "path": "/v1/maps", "raw_path": b"/v1/maps", "query_string": b"",
        "root_path": "", "scheme": "http", "http_version": "1.1", "client": ("127.0.0.1", 1), "server": ("cloud", 80),
        "headers": [(name.lower().encode(), value.encode()) for name, value in headers.items()],
    }  # fmt: skip
    with caplog.at_level(logging.WARNING):
        await create_app(services)(scope, receive, send)
    assert [message["status"] for message in sent if "status" in message] == [400]
    assert not caplog.records


async def test_bodies_over_the_limit_are_refused_with_or_without_a_length(
    client: httpx.AsyncClient, services: Services
) -> None:
    content = b" " * (services.limits.max_body + 1)
    headers = {"Content-Type": "application/json"}
    problem_of(await client.post("/v1/tokens", headers=headers, content=content), 413, "message-too-large")

    async def in_pieces() -> object:
        for start in range(0, len(content), 1000):
            yield content[start : start + 1000]

    problem_of(await client.post("/v1/tokens", headers=headers, content=in_pieces()), 413, "message-too-large")


async def test_an_absurd_content_length_is_refused(client: httpx.AsyncClient) -> None:
    headers = {"Content-Length": "9" * 5000, "Content-Type": "application/json"}
    problem_of(await client.post("/v1/tokens", headers=headers, content=b"{}"), 413, "message-too-large")


def test_openapi_describes_operations_and_declares_problems(services: Services) -> None:
    described = create_app(services).openapi()
    assert described["info"]["title"] == "PPaaS"
    operations = {
        (method, path): operation
        for path, methods in described["paths"].items()
        for method, operation in methods.items()
    }
    assert len(operations) > 30
    names = [operation["operationId"] for operation in operations.values()]
    assert len(names) == len(set(names)) and all(name.isidentifier() for name in names)
    tags = {tag["name"] for tag in described["tags"]}
    for operation in operations.values():
        assert set(operation["tags"]) <= tags and operation["description"]
        errors = {status: declared for status, declared in operation["responses"].items() if status >= "400"}
        assert {"422", "500", "503"} <= set(errors)
        assert ("401" in errors) or "security" not in operation
        for status, declared in errors.items():
            [(kind, content)] = declared["content"].items()
            assert (kind, content["example"]["status"]) == ("application/problem+json", int(status))
            Problem.model_validate(content["example"])
    assert {"Problem", "Fault"} <= set(described["components"]["schemas"])
    open_to_all = {key for key, operation in operations.items() if "security" not in operation}
    logins = {("post", f"/v1{path}") for path in oidc.PATHS}
    assert open_to_all == {
        ("post", "/v1/tokens"), ("get", "/v1/health"), ("get", "/v1/health/ready"), ("get", "/v1/oidc"), *logins,
    }  # fmt: skip
    form = operations["post", "/v1/maps"]["requestBody"]["content"]["multipart/form-data"]["schema"]
    assert form["required"] == ["id"]
    assert {"yaml", "image", "octomap"} <= set(form["properties"])


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(5.0)


@pytest.fixture
def log(clock: ManualClock, caplog: pytest.LogCaptureFixture) -> RefusalLog:
    caplog.set_level(logging.DEBUG)
    return RefusalLog(logging.getLogger("refusals"), clock)


# Warnings about clients: few a second for one address, one line each.


def test_a_refusal_is_one_warning_with_its_address(log: RefusalLog, caplog: pytest.LogCaptureFixture) -> None:
    log.add("203.0.113.7", "robot ann/tb1: conflict: connected already")
    [record] = caplog.records
    assert (record.levelname, record.getMessage()) == (
        "WARNING", "203.0.113.7: robot ann/tb1: conflict: connected already",
    )  # fmt: skip


def test_refusals_of_one_address_are_limited_and_the_rest_is_counted(
    log: RefusalLog, clock: ManualClock, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(100):
        log.add("203.0.113.7", "no")
    log.add("203.0.113.8", "no")
    assert len(caplog.records) == PER_SECOND + 1
    caplog.clear()
    clock.advance(1.0)
    log.add("203.0.113.7", "no")
    assert [record.getMessage() for record in caplog.records] == [
        f"203.0.113.7: {100 - PER_SECOND} more warnings like these were not logged", "203.0.113.7: no",
    ]  # fmt: skip


def test_text_of_a_client_cannot_forge_a_line(log: RefusalLog, caplog: pytest.LogCaptureFixture) -> None:
    log.add("203.0.113.7", "unknown robot 'x\nERROR all is lost\x1b[0m'" + "y" * 10_000)
    [message] = [record.getMessage() for record in caplog.records]
    assert "\n" not in message and "\x1b" not in message and len(message) < 600


def test_the_memory_of_addresses_is_limited(log: RefusalLog) -> None:
    for number in range(2 * MAX_ADDRESSES):
        log.add(f"2001:db8::{number:x}", "no")
    assert len(log._seen) == MAX_ADDRESSES
