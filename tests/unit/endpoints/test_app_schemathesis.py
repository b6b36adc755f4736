"""Whatever is sent to any operation of the description, the answer is one that the description foresees.

Requests are made by schemathesis: the examples of the description, its borders, and some at random, good and bad.
``make schemathesis`` sends more of them.
"""

import os
from collections.abc import Callable, Iterator

import pytest
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis.checks import load_all_checks
from schemathesis.specs.openapi.checks import negative_data_rejection, positive_data_acceptance

from tests.support.endpoints.fuzzed_rest import KNOWN, TOKEN, FuzzedService, description, fuzzed_service

EXAMPLES = int(os.environ.get("PPAAS_SCHEMATHESIS_EXAMPLES", "10"))
BEYOND_A_SCHEMA = [positive_data_acceptance]
"""A schema cannot say which cursor a list gave, or which bytes are a map's: these are refused, and so they should."""

HEADERS = {"Authorization": f"Bearer {TOKEN}"}

FRAMING = ("connection", "content-length", "transfer-encoding", "upgrade")
"""Headers by which a server tells where a request ends: with nonsense in them it is none, and no operation is asked."""


@schemathesis.hook
def map_headers(context: schemathesis.HookContext, headers: dict[str, str] | None) -> dict[str, str] | None:
    """Leave headers out that make something else of a request."""
    return headers and {name: value for name, value in headers.items() if name.lower() not in FRAMING}


load_all_checks()
DESCRIBED = schemathesis.openapi.from_dict(description())


@pytest.fixture(scope="module")
def service() -> Iterator[FuzzedService]:
    with fuzzed_service() as running:
        yield running


def answered_as_described(case: schemathesis.Case, service: FuzzedService) -> None:
    if ask(service, case) == 404 and case.path_parameters:
        # Names that are thought out are of nothing: ask the same of what is there.
        case.path_parameters = {name: KNOWN[name] for name in case.path_parameters}
        ask(service, case)


def test_of(operation_id: str) -> Callable[..., None]:
    """Return the test of one operation."""

    def test(case: schemathesis.Case, service: FuzzedService) -> None:
        answered_as_described(case, service)

    limits = settings(
        max_examples=EXAMPLES, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck)
    )
    found: Callable[..., None] = DESCRIBED.include(operation_id=operation_id).parametrize()(limits(test))
    return found


test_of.__test__ = False  # type: ignore[attr-defined]

# A name each: those that one ``parametrize`` makes of all operations share theirs, and pytest-xdist runs one of them.
for _operation in DESCRIBED.get_all_operations():
    _id = _operation.ok().definition.raw["operationId"]
    globals()[f"test_{_id}_answers_as_described"] = test_of(_id)


def ask(service: FuzzedService, case: schemathesis.Case) -> int:
    """Send a request and check the answer; return its status."""
    service.refill()
    response = case.call(service.url, headers=HEADERS)
    service.answers[case.operation.label, response.status_code] += 1
    # What no operation knows of a query is passed over, as on the web at large.
    passed_over = [negative_data_rejection] if set(case.query or ()) - query_names(case) else []
    case.validate_response(response, excluded_checks=BEYOND_A_SCHEMA + passed_over)
    return response.status_code


def query_names(case: schemathesis.Case) -> set[str]:
    """Return the names that an operation knows in a query."""
    return {each["name"] for each in case.operation.definition.raw.get("parameters", ()) if each["in"] == "query"}


def test_most_operations_were_reached(service: FuzzedService, capsys: pytest.CaptureFixture[str]) -> None:
    with capsys.disabled():
        print(f"\n{service.summary()}")  # noqa: T201
    assert len({operation for operation, _ in service.answers}) > 30
    assert not [status for _, status in service.answers if status >= 500]
