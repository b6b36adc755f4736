"""Server of scrapes, and what a scrape has while the master does not lead, or does not answer."""

import asyncio
import http.client
import socket
import urllib.error
import urllib.request
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from prometheus_client.parser import text_string_to_metric_families

from endpoints.metrics import collector as collecting
from endpoints.metrics import server as serving_metrics
from endpoints.metrics.collector import CloudCollector
from endpoints.metrics.server import MOST_CLIENTS, serve_metrics
from endpoints.metrics.snapshot import Snapshot
from engine.leadership.leadership import Leadership
from ppaas.errors import Unavailable
from storage.memory.store import MemoryStore
from tests.support.waiting import patience


@asynccontextmanager
async def serving(log: pytest.LogCaptureFixture) -> AsyncIterator[tuple[str, CloudCollector]]:
    """Serve metrics; yield the address of the server and what it collects them from."""
    log.set_level("INFO")
    collector, end = await serve_metrics(("127.0.0.1", 0), robots=False)
    try:
        yield log.messages[-1].removeprefix("serving metrics at http://").removesuffix("/metrics"), collector
    finally:
        await asyncio.to_thread(end)


async def scrape(address: str) -> dict[str, float]:
    """Return the values without labels of a scrape."""
    answer = await asyncio.to_thread(lambda: urllib.request.urlopen(f"http://{address}/metrics").read().decode())
    families = text_string_to_metric_families(answer)
    return {sample.name: sample.value for family in families for sample in family.samples if not sample.labels}


async def scrape_or_none(address: str) -> dict[str, float] | None:
    try:
        return await scrape(address)
    except (http.client.RemoteDisconnected, ConnectionResetError):
        return None


def role(found: dict[str, float]) -> list[float]:
    return [found[f"ppaas_{name}"] for name in ("leader", "epoch", "scrape_complete")]


async def test_a_standby_answers_with_its_role(caplog: pytest.LogCaptureFixture) -> None:
    async with serving(caplog) as (address, _):
        found = await scrape(address)
    assert role(found) == [0, 0, 0]
    assert "ppaas_plans_waiting" not in found and found["process_resident_memory_bytes"] > 0


async def test_a_leader_that_starts_has_its_epoch(caplog: pytest.LogCaptureFixture) -> None:
    leadership = Leadership(MemoryStore(), "here")
    await leadership.acquire(standby=False)
    async with serving(caplog) as (address, collector):
        collector.leadership = leadership
        assert role(await scrape(address)) == [1, 1, 0]
    await leadership.release()


class Silent:
    """A master that does not answer."""

    def __init__(self, fault: Exception | None = None) -> None:
        self.fault = fault

    async def read(self) -> Snapshot:
        if self.fault is not None:
            raise self.fault
        await asyncio.Event().wait()
        raise AssertionError("nothing sets it")


@pytest.mark.parametrize("source", [Silent(), Silent(Unavailable("the cloud is shutting down"))], ids=str)
async def test_a_master_that_does_not_answer_is_an_incomplete_scrape(
    source: Silent, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(collecting, "PATIENCE", 0.05)
    async with serving(caplog) as (address, collector):
        collector.source = source
        assert role(await scrape(address)) == [0, 0, 0]
        await scrape(address)
    assert sum("lacks the state" in line for line in caplog.messages) == 1, "it would be one line each scrape"


async def test_nothing_is_served_elsewhere(caplog: pytest.LogCaptureFixture) -> None:
    async with serving(caplog) as (address, _):
        with pytest.raises(urllib.error.HTTPError, match="404") as refused:
            await asyncio.to_thread(urllib.request.urlopen, f"http://{address}/v1/users")
        assert refused.value.read() == b"metrics are at /metrics\n"
        refused.value.close()


async def question(address: str) -> int:
    """Return the status of the answer to the question whether the process works."""
    answer = await asyncio.to_thread(urllib.request.urlopen, f"http://{address}/alive")
    answer.close()
    return int(answer.status)


async def test_a_process_whose_event_loop_answers_is_alive(caplog: pytest.LogCaptureFixture) -> None:
    async with serving(caplog) as (address, _):
        assert await question(address) == 200


def test_an_event_loop_that_hangs_is_not_alive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving_metrics, "PATIENCE", 0.05)
    loop = asyncio.new_event_loop()  # it does not run
    try:
        assert not serving_metrics.is_alive(loop)
    finally:
        loop.run_until_complete(asyncio.sleep(0))
        loop.close()


async def test_clients_beyond_the_limit_are_disconnected(caplog: pytest.LogCaptureFixture) -> None:
    async with serving(caplog) as (address, _):
        host, _, port = address.partition(":")
        waiting = [await asyncio.to_thread(socket.create_connection, (host, int(port))) for _ in range(MOST_CLIENTS)]
        assert await scrape_or_none(address) is None
        for each in waiting:
            each.close()
        async with patience(30):
            while not await scrape_or_none(address):
                await asyncio.sleep(0.01)


async def test_a_port_in_use_is_refused_by_name() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as used,
        pytest.raises(Unavailable, match=f"cannot serve metrics at 127.0.0.1:{used.getsockname()[1]}"),
    ):
        await serve_metrics(used.getsockname(), robots=False)
