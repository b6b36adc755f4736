"""Users whom requests name exist: readers of maps, members of groups, those with whom robots are shared."""

from typing import Any

import httpx
import pytest
from msgspec.structs import replace

from endpoints.resources.services import Services
from endpoints.sharing.named_users import check_grantee, check_readers, check_users
from ppaas.errors import NotFound
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, house, pgm, put_map, user
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.fixture
def store() -> MemoryStore:
    store = MemoryStore()
    for name in ("ann", "bob", "carl"):
        store.add_user(user(name))
    store.change_user(replace(store.user("carl"), leaving=True))
    return store


def test_all_unknown_users_are_named_with_advice(store: MemoryStore) -> None:
    assert [found.id for found in check_users(store, ["bob", "ann", "bob"])] == ["bob", "ann"]
    with pytest.raises(NotFound, match=r"^unknown user 'bbo'; check the spelling, or let an administrator create that"):
        check_users(store, ["ann", "bbo"])
    with pytest.raises(NotFound, match=r"^unknown users 'bbo, an'; check"):
        check_users(store, ["bbo", "ann", "an"])


def test_a_user_who_is_being_removed_does_not_exist(store: MemoryStore) -> None:
    with pytest.raises(NotFound, match="unknown user 'carl'"):
        check_grantee(store, "carl")


def test_everybody_and_the_readers_of_before_may_be_readers(store: MemoryStore) -> None:
    maps = MemoryMapStore()
    put_map(maps, house("office", "ann", readers=("gone",)))
    check_readers(store, maps, "office", ["*", "gone", "bob"])
    for map_id in ("office", "new"):
        with pytest.raises(NotFound, match="unknown user 'bbo'"):
            check_readers(store, maps, map_id, ["*", "bbo"])


async def _publish(client: httpx.AsyncClient, ann: dict[str, str], name: str) -> httpx.Response:
    files = {"yaml": ("house.yaml", YAML), "image": ("house.pgm", pgm())}
    return await client.post("/v1/maps", headers=ann, data={"id": "new", "readers": f"bob,{name}"}, files=files)


async def _change(client: httpx.AsyncClient, ann: dict[str, str], name: str) -> httpx.Response:
    return await client.patch("/v1/maps/house", headers=ann, json={"readers": ["bob", name]})


async def _group(client: httpx.AsyncClient, ann: dict[str, str], name: str) -> httpx.Response:
    return await client.put("/v1/groups/hall", headers=ann, json={"members": ["bob", name]})


async def _share(client: httpx.AsyncClient, ann: dict[str, str], name: str) -> httpx.Response:
    return await client.put(f"/v1/robots/tb1/shares/{name}", headers=ann, json={"role": "look"})


@pytest.mark.parametrize("ask", [_publish, _change, _group, _share])
async def test_each_entrance_refuses_an_unknown_user_by_name_and_changes_nothing(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, ask: Any
) -> None:
    ann, _ = await log_in("admin"), await log_in("bob")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    before = services.map_store.maps(), services.store.users(), services.store.robots("admin")
    detail = problem_of(await ask(client, ann, "bbo"), 404, "not-found")["detail"]
    assert detail.startswith("unknown user 'bbo'; check the spelling")
    assert (services.map_store.maps(), services.store.users(), services.store.robots("admin")) == before
    assert (await ask(client, ann, "bob")).is_success
