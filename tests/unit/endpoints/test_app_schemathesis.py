"""Every response to any request of any operation is one that the OpenAPI document declares.

Requests are made by schemathesis: the examples of the description, its borders, and some at random, good and bad.
``make schemathesis`` sends more of them.
"""

import os
from collections.abc import Callable, Iterator

import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis.checks import load_all_checks
from schemathesis.generation.hypothesis.builder import HypothesisTestConfig, HypothesisTestMode, create_test
from schemathesis.specs.openapi.checks import negative_data_rejection, positive_data_acceptance
from schemathesis.specs.openapi.schemas import OpenApiSchema

from tests.support.endpoints.fuzzed_rest import TOKEN, FuzzedService, description, fuzzed_service, operations
from tests.support.waiting import PATIENCE

EXAMPLES = int(os.environ.get("PPAAS_SCHEMATHESIS_EXAMPLES", "2"))
BEYOND_A_SCHEMA = [positive_data_acceptance]
"""Checks left out: a schema cannot describe valid cursors or map files, which are rightly refused."""

HEADERS = {"Authorization": f"Bearer {TOKEN}"}

FRAMING = ("connection", "content-length", "transfer-encoding", "upgrade")
"""Headers that delimit a request: with invalid values no operation is reached."""


@schemathesis.hook
def map_headers(context: schemathesis.HookContext, headers: dict[str, str] | None) -> dict[str, str] | None:
    """Remove headers that would change the framing of a request."""
    return headers and {name: value for name, value in headers.items() if name.lower() not in FRAMING}


load_all_checks()


@pytest.fixture(scope="module")
def schema() -> OpenApiSchema:
    return schemathesis.openapi.from_dict(description())


@pytest.fixture(scope="module")
def service() -> Iterator[FuzzedService]:
    with fuzzed_service() as running:
        yield running


@pytest.fixture(scope="module")
def session() -> Iterator[requests.Session]:
    """Return a session: without it each request makes one and connects."""
    with requests.Session() as session:
        session.trust_env = False  # else each request searches the environment for proxies
        session.headers.clear()
        yield session


@pytest.mark.parametrize("operation_id", [described["operationId"] for _, _, described in operations()])
def test_an_operation_answers_as_described(
    operation_id: str, schema: OpenApiSchema, service: FuzzedService, session: requests.Session
) -> None:
    def answers(case: schemathesis.Case) -> None:
        if ask(service, session, case) == 404 and case.path_parameters:
            # Generated names match nothing: use the names of existing objects.
            case.path_parameters = {name: service.known[name] for name in case.path_parameters}
            ask(service, session, case)

    checked_with_requests(answers, schema, operation_id)()


def checked_with_requests(
    check: Callable[[schemathesis.Case], None], schema: OpenApiSchema, operation_id: str
) -> Callable[[], None]:
    """Return a function that calls ``check`` with requests of an operation.

    ``schema.parametrize`` makes the same requests when pytest collects the tests. That takes seconds, and each process
    collects all tests to run some.
    """
    limits = settings(max_examples=EXAMPLES, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
    operation = schema.find_operation_by_id(operation_id)
    wanted = HypothesisTestConfig(schema.config, list(HypothesisTestMode), explicit_settings=limits)
    checked: Callable[[], None] = create_test(operation=operation, test_func=check, config=wanted)
    return checked


def ask(service: FuzzedService, session: requests.Session, case: schemathesis.Case) -> int:
    """Send a request and check the answer; return its status."""
    service.refill()
    session.cookies.clear()
    response = case.call(service.url, session, headers=HEADERS, timeout=PATIENCE)
    service.answers[case.operation.label, response.status_code] += 1
    # Unknown query parameters are ignored, as usual on the web.
    passed_over = [negative_data_rejection] if set(case.query or ()) - query_names(case) else []
    case.validate_response(response, excluded_checks=BEYOND_A_SCHEMA + passed_over)
    return response.status_code


def query_names(case: schemathesis.Case) -> set[str]:
    """Return the names of an operation's query parameters."""
    return {each["name"] for each in case.operation.definition.raw.get("parameters", ()) if each["in"] == "query"}


def test_most_operations_were_reached(service: FuzzedService, capsys: pytest.CaptureFixture[str]) -> None:
    with capsys.disabled():
        print(f"\n{service.summary()}")  # noqa: T201
    assert len({operation for operation, _ in service.answers}) > 30
    assert not [status for _, status in service.answers if status >= 500]
