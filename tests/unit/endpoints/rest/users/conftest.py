"""A cloud whose people an identity provider knows, over real sockets."""

import dataclasses
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import httpx
import pytest

from endpoints.app import create_app
from endpoints.oidc.logins import OidcLogins
from endpoints.oidc.provider import IdentityProvider
from endpoints.oidc.settings import OidcSettings
from endpoints.resources.services import Services
from ppaas.clock import ManualClock
from tests.support.identity.identity_server import AUDIENCE, CLIENT, SECRET, IdentityServer, identity_server

ROLES = (("operators", "admin"), ("staff", "user"))
CLOUD = "https://cloud.example"


@pytest.fixture
async def idp() -> AsyncIterator[IdentityServer]:
    async with identity_server() as running:
        yield running


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    file = tmp_path / "secret"
    file.write_text(f"{SECRET}\n")
    return file


@pytest.fixture
def settings(idp: IdentityServer, secret: Path) -> OidcSettings:
    return OidcSettings(
        issuer=idp.issuer, client_id=CLIENT, cloud_url=CLOUD, roles=ROLES, secret_file=str(secret), audience=AUDIENCE
    )


@pytest.fixture
def monotonic() -> ManualClock:
    return ManualClock(50_000.0)


Open = Callable[[OidcSettings], Awaitable[httpx.AsyncClient]]


@pytest.fixture
async def opened(services: Services, monotonic: ManualClock) -> AsyncIterator[Open]:
    """Return a function that returns a client of the cloud with these settings."""
    clients = []

    async def client(settings: OidcSettings) -> httpx.AsyncClient:
        oidc = OidcLogins(settings, IdentityProvider(settings, monotonic, timeout=0.5))
        app = create_app(dataclasses.replace(services, oidc=oidc))
        clients.append(httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://cloud"))
        return clients[-1]

    yield client
    for each in clients:
        await each.aclose()


@pytest.fixture
async def web(opened: Open, settings: OidcSettings) -> httpx.AsyncClient:
    return await opened(settings)
