"""Users and robots whose records are damaged can be removed and created again, as docs/stores.md says."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import httpx
import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.resources.services import RequestLimits, Services
from ppaas.clock import ManualClock
from storage.memory.maps import MemoryMapStore
from storage.sqlite.store import SqliteStore
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.fixture
def services(clock: ManualClock, passwords: Passwords, cloud: FakeCloud, tmp_path: Path) -> Iterator[Services]:
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        accounts = Accounts(store, clock, passwords=passwords)
        yield Services(store, MemoryMapStore(), accounts, cloud, RequestLimits(max_body=64 << 10, max_upload=1 << 20))


def damage(tmp_path: Path, table: str, key: str) -> None:
    with closing(sqlite3.connect(tmp_path / "store.sqlite", isolation_level=None)) as connection:
        connection.execute(f"UPDATE {table} SET record = x'00' WHERE id = ?", (key,))


@pytest.mark.parametrize("remover", ["ann", "admin"])
async def test_a_damaged_robot_is_removed_by_its_owner_or_an_administrator(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, tmp_path: Path, remover: str
) -> None:
    ann, bob, by = await log_in("ann"), await log_in("bob"), await log_in(remover)
    await publish(ann)
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 201
    damage(tmp_path, "robots", "tb1")
    problem_of(await client.get("/v1/robots/tb1", headers=ann), 503, "unavailable")
    problem_of(await client.delete("/v1/robots/ann:tb1", headers=bob), 404, "not-found")
    assert (await client.delete("/v1/robots/ann:tb1", headers=by)).status_code == 204
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 201


async def test_a_damaged_user_is_removed_with_all_robots(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, tmp_path: Path, services: Services
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    await publish(admin, readers="ann")
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 201
    damage(tmp_path, "users", "ann")
    services.accounts.forget_all()
    problem_of(await client.get("/v1/users/ann", headers=admin), 503, "unavailable")
    assert (await client.delete("/v1/users/ann", headers=admin)).status_code == 204
    again = await log_in("ann")
    assert (await client.get("/v1/robots", headers=again)).json()["items"] == []
    assert services.map_store.map_head("house").readers == ()
    problem_of(await client.get("/v1/robots", headers=ann), 401, "not-authenticated")
