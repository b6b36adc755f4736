"""An endpoint follows the settings of its master, and keeps them while there is none."""

import asyncio
import logging
from collections.abc import AsyncIterator, Iterator

import msgspec
import pytest

from endpoints.cloud_processes import following
from endpoints.cloud_processes.config import EndpointConfig, FrontConfig, settings_at_start
from endpoints.cloud_processes.following import FollowedSettings
from endpoints.http.connection_table import ConnectionTable
from endpoints.http.front_settings import FrontSettings
from endpoints.oidc.settings import OidcSettings
from endpoints.resources.services import Services
from endpoints.settings.live import LiveSettings
from engine.master.quotas import Quota, Quotas
from ppaas.errors import Unavailable
from tests.support.waiting import until

PROVIDER = OidcSettings(
    issuer="https://login.example", client_id="ppaas", cloud_url="https://cloud.example", roles=(("*", "user"),),
    name="the lab",
)  # fmt: skip


def config() -> EndpointConfig:
    front = FrontConfig(
        host="127.0.0.1", port=0, advertised="", dead=15.0, log_level="info", root_path="", tls_cert="", tls_key="",
        trusted_proxy=(), allow_origin=(), max_connections=None, max_connections_per_address=None,
    )  # fmt: skip
    return EndpointConfig(
        name="local-1", machine="local", run_dir="", secret="", store="", map_store="", outbox=None, reserve=None,
        recordings=None, machines=None, listen_machines=None, data="", keep_versions=None, quota=Quota(), linger=1.0,
        holder="", orphaned=1.0, allowed=(), front=front,
    )  # fmt: skip


class Endpoint:
    """Parts of an endpoint that follow settings."""

    def __init__(self, services: Services, *, is_far: bool = False) -> None:
        self.services, self.quotas, self.connections = services, Quotas(), ConnectionTable(100)
        self.fronts: list[FrontSettings] = []
        self.followed = FollowedSettings(config(), self, self.quotas, is_far=is_far)  # type: ignore[arg-type]

    def change_front(self, trusted_proxies: tuple[str, ...], allowed_origins: tuple[str, ...]) -> None:
        self.fronts.append(FrontSettings("", trusted_proxies, allowed_origins))


NOW = settings_at_start(config())
OTHER = msgspec.structs.replace(
    NOW, quota=Quota(maps=2), keep_versions=3, log_level="error", trusted_proxy=("10.0.0.1",),
    allow_origin=("https://pages.example",), max_connections=2, oidc=PROVIDER,
)  # fmt: skip


@pytest.fixture(autouse=True)
def levels() -> Iterator[None]:
    """Restore the levels of the log."""
    loggers = [logging.getLogger(), logging.getLogger("uvicorn.error")]
    before = [each.level for each in loggers]
    yield
    for each, level in zip(loggers, before, strict=True):
        each.setLevel(level)


def test_all_parts_follow(services: Services) -> None:
    endpoint = Endpoint(services)
    endpoint.followed.apply(OTHER)
    assert endpoint.quotas.of("ann") == Quota(maps=2)
    assert services.keep_versions == 3
    assert services.oidc is not None and services.oidc.name == "the lab"
    assert logging.getLogger().level == logging.getLogger("uvicorn.error").level == logging.ERROR
    assert endpoint.fronts == [FrontSettings("", ("10.0.0.1",), ("https://pages.example",))]
    assert [endpoint.connections.admit(Quiet(), host) for host in "abc"] == [True, True, True]
    assert len(endpoint.connections) == 2
    provider = services.oidc
    endpoint.followed.apply(msgspec.structs.replace(OTHER, quota=Quota()))
    assert services.oidc is provider, "what the provider has published is not read again"
    endpoint.followed.apply(NOW)
    assert (services.oidc, services.keep_versions) == (None, None)
    assert logging.getLogger().level == logging.INFO


def test_an_endpoint_of_another_host_follows_what_holds_in_the_whole_cloud(services: Services) -> None:
    endpoint = Endpoint(services, is_far=True)
    endpoint.followed.apply(OTHER)
    assert (endpoint.quotas.of("ann"), services.keep_versions) == (Quota(maps=2), 3)
    assert (services.oidc, endpoint.fronts) == (None, [])
    assert [endpoint.connections.admit(Quiet(), host) for host in "abc"] == [True, True, True]
    assert len(endpoint.connections) == 3


class Quiet:
    """Connection that makes room."""

    def make_room(self) -> None:
        pass


class Master:
    """Master that is away at first, and then has these settings in turn."""

    def __init__(self) -> None:
        self.away = True
        self.known: list[LiveSettings | None] = []

    async def changed(self, known: LiveSettings | None) -> LiveSettings:
        self.known.append(known)
        if self.away:
            self.away = False
            raise Unavailable("there is no master")
        if known is None:
            return NOW
        if known == NOW:
            return OTHER
        await asyncio.Event().wait()
        raise AssertionError


@pytest.fixture
async def following_master(services: Services, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Master]:
    monkeypatch.setattr(following, "RETRY", 0.01)
    master, endpoint = Master(), Endpoint(services)
    task = asyncio.create_task(endpoint.followed.run(master))
    yield master
    task.cancel()


async def test_each_change_is_followed_also_after_a_time_without_a_master(
    following_master: Master, services: Services
) -> None:
    await until(lambda: services.keep_versions == 3)
    await until(lambda: following_master.known == [None, None, NOW, OTHER])
