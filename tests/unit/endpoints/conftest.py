"""Application with stores in memory and a cloud without machines."""

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path

import httpx
import pytest
from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import RequestLimits, Services
from engine.control.robot_stops import RobotStops
from ppaas.clock import ManualClock
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.names import is_name
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.robot_world import World, robot_world
from tests.support.storage.records import YAML, pgm

PASSWORD = "correct horse"


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1_000_000.0)


@pytest.fixture
def passwords() -> Iterator[Passwords]:
    """Hash with argon2id at its lowest cost."""
    hashing = Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=2, waiting=8)
    yield hashing
    hashing.close()


@pytest.fixture
def cloud() -> FakeCloud:
    return FakeCloud()


@pytest.fixture
def services(clock: ManualClock, passwords: Passwords, cloud: FakeCloud) -> Services:
    store = MemoryStore()
    cloud.stops = RobotStops(cloud, store)
    accounts = Accounts(store, clock, passwords=passwords)
    return Services(store, MemoryMapStore(), accounts, cloud, RequestLimits(max_body=64 << 10, max_upload=1 << 20))


@pytest.fixture
async def world(tmp_path: Path, services: Services) -> AsyncIterator[World]:
    """Run a cloud on a real port whose containers the test plays."""
    async with robot_world(tmp_path, services) as running:
        yield running


@pytest.fixture
async def client(services: Services) -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(create_app(services))
    async with httpx.AsyncClient(transport=transport, base_url="http://cloud") as opened:
        yield opened


LogIn = Callable[[str], Awaitable[dict[str, str]]]


@pytest.fixture
def log_in(services: Services) -> LogIn:
    """Return the header of a user, who is created if missing; ``admin`` is an administrator."""

    async def header(user: str) -> dict[str, str]:
        if user not in {known.id for known in services.store.users()}:
            await services.accounts.register(user, PASSWORD, "admin" if user == "admin" else "user")
        return {"Authorization": f"Bearer {await services.accounts.login(user, PASSWORD)}"}

    return header


Publish = Callable[..., Awaitable[httpx.Response]]


@pytest.fixture
def publish(client: httpx.AsyncClient, services: Services) -> Publish:
    """Return a function that publishes a map, and creates the users who are to read it."""

    async def send(
        headers: dict[str, str],
        map_id: str = "house",
        yaml: bytes = YAML,
        image: bytes = pgm(),
        **fields: str,
    ) -> httpx.Response:
        for reader in map(str.strip, fields.get("readers", "").split(",")):
            if is_name(reader) and reader not in {known.id for known in services.store.users()}:
                await services.accounts.register(reader, PASSWORD)
        files = {"yaml": ("house.yaml", yaml), "image": ("house.pgm", image)}
        return await client.post("/v1/maps", headers=headers, data={"id": map_id, **fields}, files=files)

    return send
