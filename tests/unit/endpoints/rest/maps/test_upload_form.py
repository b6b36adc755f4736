"""Form that publishes a map."""

import asyncio
import threading
from collections.abc import AsyncIterator

import httpx
import pytest

from endpoints.resources.services import Services
from endpoints.rest.maps.multipart import MAX_WAITING, MIN_BATCH, consume
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.mark.parametrize("readers", ["bob;carl", "../x", ",".join(f"u{n}" for n in range(257))])
async def test_invalid_reader_names_are_refused(log_in: LogIn, publish: Publish, readers: str) -> None:
    answer = await publish(await log_in("ann"), readers=readers)
    assert answer.status_code in (400, 422)
    problem_of(answer, answer.status_code, answer.json()["type"].rpartition(":")[2])


@pytest.mark.parametrize(
    ("data", "files", "missing"),
    [
        ({}, {"yaml": b"", "image": b""}, "'id'"),
        ({"id": "house"}, {"yaml": b""}, "'image'"),
        ({"id": "house", "yaml": "image: x"}, {"image": b""}, "'yaml'"),
        ({}, {"id": b"house", "yaml": b"", "image": b""}, "'id'"),
    ],
)
async def test_a_missing_form_part_is_named(
    client: httpx.AsyncClient, log_in: LogIn, data: dict[str, str], files: dict[str, bytes], missing: str
) -> None:
    answer = await client.post("/v1/maps", headers=await log_in("ann"), data=data, files=files)
    assert missing in problem_of(answer, 422, "invalid-parameter")["detail"]


@pytest.mark.parametrize(
    ("content_type", "content"),
    [
        ("multipart/form-data", b"x"),
        ("multipart/form-data; boundary=b", b"\x00\xff" * 100),
        ("multipart/form-data; boundary=b", b'--b\r\nContent-Disposition: form-data; name="id"\r\n\r\nhou'),
    ],
)
async def test_a_malformed_form_is_a_problem(
    client: httpx.AsyncClient, log_in: LogIn, content_type: str, content: bytes
) -> None:
    headers = await log_in("ann") | {"Content-Type": content_type}
    answer = await client.post("/v1/maps", headers=headers, content=content)
    assert answer.status_code in (400, 422)
    assert answer.headers["content-type"] == "application/problem+json"


async def test_a_body_of_another_content_type_is_refused(client: httpx.AsyncClient, log_in: LogIn) -> None:
    for headers in ({"Content-Type": "application/json"}, {}):
        answer = await client.post("/v1/maps", headers=await log_in("ann") | headers, content=b"{}")
        assert "multipart/form-data" in problem_of(answer, 415, "unsupported-media-type")["detail"]


async def test_uploads_over_the_limit_are_refused_with_or_without_a_length(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    problem_of(await publish(ann, image=bytes(services.limits.max_upload)), 413, "message-too-large")

    async def endless() -> object:
        yield b'--b\r\nContent-Disposition: form-data; name="image"; filename="x"\r\n\r\n'
        for _ in range(100):
            yield bytes(64 << 10)

    headers = ann | {"Content-Type": "multipart/form-data; boundary=b"}
    problem_of(await client.post("/v1/maps", headers=headers, content=endless()), 413, "message-too-large")
    assert services.map_store.maps() == []


BLOCK = MIN_BATCH // 2


async def stream(blocks: list[bytes], *, then: Exception | None = None) -> AsyncIterator[bytes]:
    for block in blocks:
        yield block
    if then is not None:
        raise then


async def test_blocks_are_consumed_in_order_in_another_thread() -> None:
    blocks = [
        bytes([number]) * size for number, size in enumerate((1, BLOCK, BLOCK, 0, 3 * MIN_BATCH, 7, MAX_WAITING, 1))
    ]
    got: list[bytes] = []
    threads = set()

    def take(block: bytes) -> None:
        threads.add(threading.get_ident())
        got.append(block)

    await consume(stream(blocks), take)
    assert got == blocks
    assert threading.get_ident() not in threads


async def test_blocks_are_read_ahead_of_a_busy_thread_within_a_bound() -> None:
    read = 0
    ahead = threading.Event()
    seen = []

    async def counted() -> AsyncIterator[bytes]:
        nonlocal read
        for _ in range(100):
            read += 1
            if read * BLOCK >= MAX_WAITING:
                ahead.set()
            await asyncio.sleep(0)
            yield bytes(BLOCK)

    def take(_block: bytes) -> None:
        assert ahead.wait(10), "nothing more was read while the thread was busy"
        seen.append(read)

    await consume(counted(), take)
    assert len(seen) == 100
    most_ahead = max(read - place for place, read in enumerate(seen))
    assert most_ahead <= 2 * MAX_WAITING // BLOCK + 1


async def test_consume_raises_the_exception_of_its_thread() -> None:
    def take(block: bytes) -> None:
        if block == b"bad":
            raise ValueError("bad block")

    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([bytes(MAX_WAITING), b"bad"]), take)
    with pytest.raises(ValueError, match="bad block"):
        await consume(stream([b"bad", bytes(MAX_WAITING), bytes(MAX_WAITING), bytes(MAX_WAITING)]), take)


@pytest.mark.parametrize("cancel", [False, True])
async def test_consume_waits_for_its_thread_on_errors_and_cancellation(cancel: bool) -> None:
    began, released = threading.Event(), threading.Event()
    taking: list[str] = []

    def take(_block: bytes) -> None:
        taking.append("began")
        began.set()
        assert released.wait(10)
        taking.append("ended")

    async def cut_short() -> AsyncIterator[bytes]:
        yield bytes(MAX_WAITING)
        await asyncio.to_thread(began.wait, 10)
        if cancel:
            await asyncio.Event().wait()
        raise ConnectionError("the client is gone")

    task = asyncio.create_task(consume(cut_short(), take))
    await asyncio.to_thread(began.wait, 10)
    await asyncio.sleep(0.05)
    if cancel:
        task.cancel()
    assert not (await asyncio.wait([task], timeout=0.05))[0], "it ended before its thread did"
    released.set()
    with pytest.raises(asyncio.CancelledError if cancel else ConnectionError):
        await task
    assert taking == ["began", "ended"]
