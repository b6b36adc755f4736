"""Quotas of what users store, with two endpoints that share the stores and the turns of the users.

What one endpoint remembers and the other changes: the number of robots and maps, new versions, removed versions and
maps, proposals, URDFs of other sizes, removed URDFs, users who come again.
"""

import asyncio
import dataclasses
import time
from collections.abc import Callable
from typing import Any

import pytest

from endpoints.accounts.usage import Usage
from endpoints.accounts.user_turns import LocalTurns
from endpoints.resources.services import Services
from ppaas.errors import QuotaExceeded, Unavailable
from storage.memory.store import MemoryStore
from storage.records import Limits, Publication, RobotRecord
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.storage.records import GivenMap, house, pgm, propose, robot, user

SIZE = len(pgm(100, 100))


class SlowStore(MemoryStore):
    """A store that takes its time, so that two checks overlap if they can."""

    def robots(self, *arguments: Any, **fields: Any) -> list[RobotRecord]:
        found = super().robots(*arguments, **fields)
        time.sleep(0.005)
        return found


@pytest.fixture
def both(services: Services) -> list[Services]:
    """Return the services of two endpoints."""
    turns, store = LocalTurns(), SlowStore()
    store.add_user(user("ann"))
    return [dataclasses.replace(services, store=store, usage=Usage(turns)) for _ in range(2)]


@pytest.fixture
def limit(cloud: FakeCloud) -> Callable[..., None]:
    return lambda **limits: cloud.quotas.set_limits("ann", Limits(**limits))


def put_robot(services: Services, name: str) -> None:
    with services.usage.new_robot(services.store, services.cloud.quotas, "ann", name):
        services.store.put_robot(robot(name))


def publish(services: Services, given: GivenMap) -> None:
    with services.map_store.stage() as upload:
        for part, data in given.files.items():
            upload.add(part, [data])
        with services.usage.new_map(services, "ann", given.id, upload):
            services.map_store.publish(upload, Publication(given.id, "ann", given.created))


def put_urdf(services: Services, name: str, size: int) -> None:
    with services.usage.new_urdf(services, "ann", name, size):
        services.store.put_urdf("ann", name, b"x" * size)


async def refused(*works: Any) -> int:
    """Return the number of works that a quota refuses."""
    results = await asyncio.gather(*works, return_exceptions=True)
    assert all(result is None or isinstance(result, QuotaExceeded) for result in results), results
    return sum(result is not None for result in results)


def image(number: int) -> GivenMap:
    return house(image=pgm(100, 100, number))


async def test_racing_endpoints_never_exceed_the_quota_of_robots(
    both: list[Services], limit: Callable[..., None]
) -> None:
    limit(robots=5)
    works = [both[n % 2].usage.in_turn("ann", put_robot, both[n % 2], f"tb{n}") for n in range(12)]
    assert await refused(*works) == 7
    assert len(both[0].store.robots("ann")) == 5


async def test_racing_endpoints_never_exceed_the_quotas_of_maps_and_bytes(
    both: list[Services], limit: Callable[..., None]
) -> None:
    limit(maps=3)
    maps = [house(f"m{n}", image=pgm(100, 100, n)) for n in range(8)]
    works = [both[n % 2].usage.in_turn("ann", publish, both[n % 2], one) for n, one in enumerate(maps)]
    assert await refused(*works) == 5
    limit(stored_bytes=6 * SIZE)
    works = [
        both[n % 2].usage.in_turn("ann", publish, both[n % 2], house("m0", image=pgm(100, 100, 50 + n)))
        for n in range(8)
    ]
    await refused(*works)
    stored = Usage().stored.of_user(both[0].store, both[0].map_store, "ann")
    assert 5 * SIZE < stored <= 6 * SIZE


async def counts_like_a_new_one(services: Services) -> bool:
    """Return whether an endpoint counts in a turn of ann what is stored."""
    stores = services.store, services.map_store, "ann"
    return await services.usage.in_turn("ann", services.usage.stored.of_user, *stores) == Usage().stored.of_user(
        *stores
    )


async def test_each_endpoint_counts_what_the_other_has_added_and_removed(both: list[Services]) -> None:
    first, second = both
    for number in range(3):
        await first.usage.in_turn("ann", publish, first, image(number))
    for name in ("tb1", "tb2"):
        await first.usage.in_turn("ann", put_robot, first, name)
        await first.usage.in_turn("ann", put_urdf, first, name, 1000)
    oldest = first.map_store.versions("house")[-1].version
    changes: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
        (publish, (second, image(3))),
        (second.map_store.remove_versions, ("house", [oldest])),
        (propose, (second.map_store, image(4))),
        (put_urdf, (second, "tb1", 5000)),
        (second.store.remove_urdf, ("ann", "tb2")),
        (second.map_store.remove_map, ("house",)),
    ]
    for work, arguments in changes:
        assert await counts_like_a_new_one(first)
        before = first.usage.stored.of_user(first.store, first.map_store, "ann")
        await second.usage.in_turn("ann", work, *arguments)
        assert await counts_like_a_new_one(first)
        assert first.usage.stored.of_user(first.store, first.map_store, "ann") != before


async def test_what_is_known_is_read_again_only_after_a_turn_of_another_endpoint(
    both: list[Services], monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = both
    reads = list[str]()
    versions = first.map_store.versions

    def counted(map_id: str, **arguments: Any) -> Any:
        reads.append(map_id)
        return versions(map_id, **arguments)

    monkeypatch.setattr(first.map_store, "versions", counted)
    await first.usage.in_turn("ann", publish, first, image(0))
    await first.usage.in_turn("ann", publish, first, image(1))
    reads.clear()
    for _ in range(3):
        assert await counts_like_a_new_one(first)
    assert len(reads) == 3, "those of the new ones"
    await second.usage.in_turn("ann", publish, second, image(2))
    reads.clear()
    assert await counts_like_a_new_one(first)
    assert len(reads) == 2


async def test_a_publication_that_fails_after_it_was_stored_is_counted(
    both: list[Services], limit: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = both[0]
    await first.usage.in_turn("ann", publish, first, image(0))
    stored = first.map_store.publish

    def time_out(*arguments: Any) -> None:
        stored(*arguments)
        raise Unavailable("no answer in time")

    with monkeypatch.context() as patch:
        patch.setattr(first.map_store, "publish", time_out)
        with pytest.raises(Unavailable):
            await first.usage.in_turn("ann", publish, first, image(1))
    assert await counts_like_a_new_one(first)
    limit(stored_bytes=int(2.5 * SIZE))
    assert await refused(first.usage.in_turn("ann", publish, first, image(2))) == 1
