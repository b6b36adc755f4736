import asyncio

import pytest

from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.fabric.zenoh_config import RouterCredentials
from ppaas.errors import InvalidParameter, NotFound, PPaaSError, Unavailable
from tests.support.waiting import until


@pytest.fixture
async def router(tmp_path):
    process = RouterProcess(tmp_path)
    await process.start()
    yield process
    await process.close()


@pytest.fixture
async def pair(router):
    """Two sessions, connected through the router."""
    one, other = [await Fabric.open(router.endpoint, router.credentials) for _ in range(2)]
    yield one, other
    await one.close()
    await other.close()


async def test_published_payload_arrives_with_its_key(pair):
    one, other = pair
    received = []
    one.subscribe("ppaas/map/house/*/*/position", lambda key, payload: received.append((key, payload)))

    def publish_and_look() -> bool:
        other.publish("ppaas/map/house/ann/tb1/position", b"here")
        return bool(received)

    await until(publish_and_look)
    assert set(received) == {("ppaas/map/house/ann/tb1/position", b"here")}


async def test_closed_subscription_receives_nothing(pair):
    one, other = pair
    first, second = [], []
    subscription = one.subscribe("a", lambda key, payload: first.append(payload))
    one.subscribe("a", lambda key, payload: second.append(payload))
    subscription.close()

    def publish_and_look() -> bool:
        other.publish("a", b"x")
        return bool(second)

    await until(publish_and_look)
    assert first == []


async def test_a_request_is_answered(pair):
    one, other = pair

    async def upper(key: str, payload: bytes) -> bytes:
        return key.encode() + payload.upper()

    one.serve("store/*", upper)
    assert await other.request("store/plan", b"abc") == b"store/planABC"


async def test_a_large_answer_arrives_whole(pair):
    one, other = pair
    large = bytes(range(256)) * 40_000  # 10 MB

    async def give(key: str, payload: bytes) -> bytes:
        return large

    one.serve("store/map", give)
    assert await other.request("store/map", large, timeout=30.0) == large


async def test_a_request_waits_for_a_server_that_starts_later(pair):
    one, other = pair

    async def answer(key: str, payload: bytes) -> bytes:
        return b"late"

    request = asyncio.create_task(other.request("store/plan", b""))
    await asyncio.sleep(0)
    one.serve("store/plan", answer)
    assert await request == b"late"


async def test_a_request_id_is_executed_once(pair):
    one, other = pair
    counted = []

    async def count(key: str, payload: bytes) -> bytes:
        counted.append(payload)
        return str(len(counted)).encode()

    one.serve("count", count)
    answers = await asyncio.gather(*(other.request("count", b"x", id="1") for _ in range(5)))
    assert answers == [b"1"] * 5
    assert await other.request("count", b"x", id="2") == b"2"


async def test_a_request_slower_than_its_repetition_is_executed_once(pair):
    one, other = pair
    begun = []

    async def slowly(key: str, payload: bytes) -> bytes:
        begun.append(payload)
        await asyncio.sleep(1.5)
        return b"done"

    one.serve("slow", slowly)
    assert await other.request("slow", b"x") == b"done"
    assert begun == [b"x"]


async def test_slow_requests_do_not_delay_others(pair):
    one, other = pair
    go = asyncio.Event()

    async def wait_or_not(key: str, payload: bytes) -> bytes:
        if payload == b"wait":
            await go.wait()
        return payload

    one.serve("work", wait_or_not)
    waiting = [asyncio.create_task(other.request("work", b"wait")) for _ in range(20)]
    assert await other.request("work", b"quick") == b"quick"
    go.set()
    assert await asyncio.gather(*waiting) == [b"wait"] * 20


async def test_an_error_of_the_server_reaches_the_client(pair):
    one, other = pair

    async def refuse(key: str, payload: bytes) -> bytes:
        if payload == b"bug":
            raise KeyError("secret")
        raise NotFound("plan", "p1")

    one.serve("store/plan", refuse)
    with pytest.raises(NotFound, match="unknown plan 'p1'"):
        await other.request("store/plan", b"")
    with pytest.raises(PPaaSError, match="internal error: KeyError") as raised:
        await other.request("store/plan", b"bug")
    assert "secret" not in str(raised.value)


async def test_unanswered_request_raises_unavailable_after_its_timeout(pair):
    _, other = pair
    with pytest.raises(Unavailable, match=r"no answer from 'nobody' within 0\.2 s"):
        await other.request("nobody", b"", timeout=0.2)


@pytest.mark.parametrize("timeout", [0.0, -1.0, 61.0, float("nan")])
async def test_the_timeout_of_a_request_is_bounded(pair, timeout):
    with pytest.raises(InvalidParameter, match="60 s"):
        await pair[0].request("a", b"", timeout=timeout)


async def test_liveliness_tokens_appear_and_disappear(pair):
    one, other = pair
    seen: list[tuple[str, bool]] = []
    token = one.announce("live/m1")
    other.watch("live/*", lambda key, alive: seen.append((key, alive)))
    await until(lambda: seen == [("live/m1", True)])
    token.close()
    await until(lambda: seen == [("live/m1", True), ("live/m1", False)])


async def test_closing_twice_is_allowed(router):
    fabric = await Fabric.open(router.endpoint, router.credentials)
    fabric.subscribe("a", lambda key, payload: None)
    await fabric.close()
    await fabric.close()


async def test_unknown_credentials_get_no_session(router):
    with pytest.raises(Unavailable, match="no session"):
        await Fabric.open(router.endpoint, RouterCredentials("agent", "guess"), timeout=0.1)
