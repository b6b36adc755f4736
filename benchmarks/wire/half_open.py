"""Half-open connections: answers to a client while strangers hold thousands of connections without a request."""

import asyncio
import contextlib
import socket
import time
from collections.abc import AsyncIterator
from urllib.parse import urlsplit

import msgspec
from rich.progress import Progress

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, median_and_p99
from benchmarks.wire.site import Endpoints
from endpoints.http.connection_table import raise_file_limit
from ppaas.errors import PPaaSError
from robots.client.rest import RestClient

PART = "half-open"
STRANGERS, QUICK = 10_000, 500
SAMPLES, FEW = 500, 20
ADDRESSES = 4
"""Number of loopback addresses from which strangers connect, since connections of one address are limited."""

BEGUN = b"GET /v1/health HTTP/1.1\r\nHost: "
"""Bytes that half of the strangers send; the others send nothing."""

OWN_FILES = 200
"""Open files of the bench beside the connections."""


async def measure(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Request the state of the cloud over new connections, before and while strangers connect and stay."""
    strangers = min(QUICK if quick else STRANGERS, raise_file_limit() - OWN_FILES)
    samples, rest = FEW if quick else SAMPLES, RestClient(site.target.url)
    task = progress.add_task(f"{strangers:,} half-open connections", total=2 * samples)
    alone, failed = await _answers(rest, samples)
    progress.advance(task, samples)
    endpoints = Endpoints(site)
    async with _half_open(site.target.url, strangers) as opening:
        among, failed_among = await _answers(rest, samples)
        await opening
        late, failed_late = await _answers(rest, samples)
        held = sum(process.num_fds() for process in endpoints.processes)
    progress.remove_task(task)
    return figures(alone, [*among, *late], failed + failed_among + failed_late, strangers, held)


async def _answers(rest: RestClient, count: int) -> tuple[list[float], int]:
    """Return the times of requests [s], each over a connection of its own, and how many failed."""
    times, failed = [], 0
    for _ in range(count):
        began = time.perf_counter()
        try:
            await rest.get("/v1/health/ready")
        except PPaaSError:
            failed += 1
        times.append(time.perf_counter() - began)
    return times, failed


@contextlib.asynccontextmanager
async def _half_open(url: str, count: int) -> AsyncIterator["asyncio.Task[None]"]:
    """Open connections during the block, and close them after it; yield the task that opens them."""
    parts = urlsplit(url)
    sockets: list[socket.socket] = []

    def connect() -> None:
        for number in range(count):
            source = f"127.0.0.{2 + number % ADDRESSES}", 0
            sockets.append(socket.create_connection((parts.hostname, parts.port), 30.0, source))
            if number % 2:
                sockets[-1].sendall(BEGUN)

    opening = asyncio.create_task(asyncio.to_thread(connect))
    try:
        yield opening
    finally:
        await asyncio.gather(opening, return_exceptions=True)
        for each in sockets:
            each.close()


def figures(alone: list[float], among: list[float], failed: int, strangers: int, held: int) -> list[Figure]:
    """Return the figures.

    Parameters
    ----------
    alone, among : list of float
        Times of requests, before and while strangers connect and stay [s].
    failed : int
        Number of requests without an answer.
    strangers : int
        Number of connections without a request that were opened.
    held : int
        Number of open files of the endpoints at the end.
    """
    bare = median_and_p99(PART, "request, nobody else", alone, note="a connection of its own")
    note = f"the same while {strangers:,} connections are opened and stay, half of them with a head without an end"
    return [
        *median_and_p99(PART, "request among half-open connections", among, note=note),
        *(msgspec.structs.replace(figure, yardstick=True) for figure in bare),
        Figure(PART, "requests without an answer", failed, "", limit=0, note=f"of {len(alone) + len(among):,}"),
        Figure(PART, "open files of the endpoint", held, "", note="those that wait longest are closed for others"),
    ]  # fmt: skip
