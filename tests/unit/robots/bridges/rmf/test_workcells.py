"""Workcells in a graph in memory, and a cloud whose tasks are set by the test."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest

from ppaas.errors import Conflict, Unavailable
from robots.bridges.rmf import workcells
from robots.bridges.rmf.workcells import WorkcellBridge
from tests.support.ros2.fake_transport import FakeTransport
from tests.support.waiting import until

TASK = {
    "id": "t1", "map": "office", "places": [[1, 2, 0]], "visited": 1, "holding": 7.5, "needs_confirmation": True,
    "holds": [{"dispenser": "belt"}],
}  # fmt: skip


class Cloud:
    """REST client of a cloud with one task."""

    def __init__(self) -> None:
        self.confirmed: list[str] = []
        self.errors: list[Exception] = []

    async def items(self, path: str, **filters: Any) -> list[dict[str, Any]]:
        assert (path, filters) == ("/v1/maps/office/tasks", {"state": "open"})
        return [] if self.confirmed else [TASK]

    async def post(self, path: str, value: Any) -> None:
        if self.errors:
            raise self.errors.pop()
        self.confirmed.append(path)


@pytest.fixture
def cloud(monkeypatch: pytest.MonkeyPatch) -> Cloud:
    """Return the cloud."""
    monkeypatch.setattr(workcells, "PERIOD", 0.01)
    monkeypatch.setattr("ppaas.wire.rmf.workcells.REPEAT", 0.02)
    return Cloud()


@pytest.fixture
async def graph(cloud: Cloud) -> AsyncIterator[FakeTransport]:
    """Serve workcells in a graph."""
    transport = FakeTransport()
    bridge = WorkcellBridge(cloud, {"office"}, "carts")  # type: ignore[arg-type]
    serving = asyncio.create_task(bridge.serve(transport))
    await until(lambda: "/dispenser_requests" in transport.published)
    yield transport
    serving.cancel()
    await asyncio.gather(serving, return_exceptions=True)


def succeed(graph: FakeTransport) -> None:
    request = graph.published["/dispenser_requests"][-1]
    graph.say("/dispenser_results", {"request_guid": request["request_guid"], "source_guid": "belt", "status": 1})


async def test_a_dispenser_is_asked_and_its_success_confirms_the_task(graph: FakeTransport, cloud: Cloud) -> None:
    [request, *_] = graph.published["/dispenser_requests"]
    assert (request["target_guid"], request["transporter_type"]) == ("belt", "carts")
    succeed(graph)
    await until(lambda: cloud.confirmed == ["/v1/maps/office/tasks/t1/confirm"])
    assert "/ingestor_requests" not in graph.published


async def test_a_cloud_that_does_not_answer_is_asked_again(graph: FakeTransport, cloud: Cloud) -> None:
    cloud.errors = [Unavailable("it restarts")]
    succeed(graph)
    await until(lambda: not cloud.errors)
    number = len(graph.published["/dispenser_requests"])
    await until(lambda: len(graph.published["/dispenser_requests"]) > number)
    succeed(graph)
    await until(lambda: len(cloud.confirmed) == 1)


async def test_a_task_that_was_confirmed_by_hand_is_no_error(graph: FakeTransport, cloud: Cloud) -> None:
    cloud.errors = [Conflict("it does not wait")]
    succeed(graph)
    await until(lambda: not cloud.errors)
    assert cloud.confirmed == []
