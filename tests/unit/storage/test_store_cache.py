"""Values of a store are cached, and used for longer while the store is unreachable."""

import asyncio
import math

import pytest

from ppaas.errors import NotFound, Unavailable
from storage.store_cache import RETRY, StoreCache


class Source:
    """Reads a value that the test sets, and counts the queries; an exception is raised."""

    def __init__(self, value: str | Exception = "one", expires: float = math.inf) -> None:
        self.value = value
        self.expires = expires
        self.queries = 0

    async def __call__(self) -> tuple[str, float]:
        self.queries += 1
        value = self.value
        await asyncio.sleep(0)
        if isinstance(value, Exception):
            raise value
        return value, self.expires


async def test_a_value_is_read_again_after_its_lifetime() -> None:
    cache, source = StoreCache[str](lifetime=30.0), Source()
    assert await cache.read("a", 0.0, source) == "one"
    source.value = "two"
    assert await cache.read("a", 29.0, source) == "one"
    assert await cache.read("a", 30.0, source) == "two"
    assert source.queries == 2


async def test_a_value_is_not_used_after_it_has_expired() -> None:
    cache, source = StoreCache[str](), Source(expires=5.0)
    await cache.read("a", 0.0, source)
    source.value = Unavailable("no node answers")
    assert await cache.read("a", 4.0, source) == "one"
    with pytest.raises(Unavailable):
        await cache.read("a", 5.0, source)


async def test_an_unreachable_store_is_queried_now_and_then_until_patience_ends() -> None:
    cache, source = StoreCache[str](lifetime=10.0, patience=100.0), Source()
    await cache.read("a", 0.0, source)
    source.value = Unavailable("no node answers")
    for now in (20.0, 20.0 + RETRY / 2.0, 20.0 + RETRY):
        assert await cache.read("a", now, source) == "one"
    assert source.queries == 3
    assert await cache.read("a", 98.0, source) == "one"
    with pytest.raises(Unavailable):
        await cache.read("a", 100.0, source)


async def test_other_errors_are_raised_although_a_value_is_known() -> None:
    cache, source = StoreCache[str](lifetime=10.0), Source()
    await cache.read("a", 0.0, source)
    source.value = NotFound("map", "a")
    with pytest.raises(NotFound):
        await cache.read("a", 20.0, source)


async def test_a_value_that_is_forgotten_while_it_is_read_is_not_cached() -> None:
    cache, source = StoreCache[str](), Source()
    reading = asyncio.create_task(cache.read("a", 0.0, source))
    await asyncio.sleep(0)
    source.value = "two"
    cache.forget("a")
    assert await reading == "one"
    assert await cache.read("a", 0.0, source) == "two"


async def test_values_are_forgotten_by_key_and_by_content() -> None:
    cache, source = StoreCache[str](), Source()
    for key in "abc":
        await cache.read(key, 0.0, source)
    source.value = "two"
    cache.forget("a")
    assert [await cache.read(key, 0.0, source) for key in "abc"] == ["two", "one", "one"]
    cache.forget_where(lambda value: value == "one")
    assert [await cache.read(key, 0.0, source) for key in "abc"] == ["two", "two", "two"]


async def test_the_least_recently_used_value_is_evicted() -> None:
    cache, source = StoreCache[str](size=2), Source()
    for key in "abac":
        await cache.read(key, 0.0, source)
    assert source.queries == 3
    await cache.read("a", 0.0, source)
    assert source.queries == 3
    await cache.read("b", 0.0, source)
    assert source.queries == 4
