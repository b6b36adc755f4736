"""The application with in-memory stores and a cloud without machines, on a real socket, and users with tokens."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.robot_stops import RobotStops
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.cloud.command_line import PASSWORD
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.serving import serve


@dataclass
class ServedUsers:
    """Address of the application, its parts, and a token for each user."""

    url: str
    services: Services
    cloud: FakeCloud
    tokens: dict[str, str] = field(default_factory=dict)


@asynccontextmanager
async def serving_users() -> AsyncIterator[ServedUsers]:
    """Serve; the users are ann, bob and the administrator admin."""
    store, cloud = MemoryStore(), FakeCloud()
    cloud.stops = RobotStops(cloud, store)
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=2))
    services = Services(store, MemoryMapStore(), accounts, cloud)
    async with serve(create_app(services)) as port:
        served = ServedUsers(f"http://127.0.0.1:{port}", services, cloud)
        for user in ("ann", "bob", "admin"):
            await accounts.register(user, PASSWORD, "admin" if user == "admin" else "user")
            served.tokens[user] = await accounts.login(user, PASSWORD)
        yield served
    accounts.close()
