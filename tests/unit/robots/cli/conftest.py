"""Command line against a real server: the application with in-memory stores and a cloud without machines."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.robot_stops import RobotStops
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.cloud.command_line import PASSWORD, CommandLine
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.serving import serve
from tests.support.storage.records import YAML, pgm


@pytest.fixture
async def ppaas(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[CommandLine]:
    """Return the command line; the users are ann, bob and the administrator admin."""
    store, cloud = MemoryStore(), FakeCloud()
    cloud.stops = RobotStops(cloud, store)
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=2))
    services = Services(store, MemoryMapStore(), accounts, cloud)
    async with serve(create_app(services)) as port:
        line = CommandLine(f"http://127.0.0.1:{port}", services, cloud, capsys.readouterr, monkeypatch)
        for user in ("ann", "bob", "admin"):
            await accounts.register(user, PASSWORD, "admin" if user == "admin" else "user")
            line.tokens[user] = await accounts.login(user, PASSWORD)
        yield line
    accounts.close()


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """Return the YAML file of a map, with its image in the same folder."""
    (tmp_path / "house.yaml").write_bytes(YAML)
    (tmp_path / "house.pgm").write_bytes(pgm())
    return tmp_path / "house.yaml"
