"""Versions of maps are removed by their owner, and expire after publications."""

import dataclasses

import httpx
import pytest

from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.views import ContainerView
from engine.specs.containers import MapVersion
from ppaas.errors import Unavailable
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import house, pgm, put_map
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.fixture
def services(services: Services) -> Services:
    return dataclasses.replace(services, keep_versions=2)


def robot_on(cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch, version: str, masks: tuple[str, ...] = ()) -> None:
    pinned = MapVersion("cellar" if masks else "house", version)
    view = ContainerView(
        id="c1", kind="robot", user="ann", robot="tb1", map=pinned, machine="local", cores=1.0, state="ready",
        pid=None, pss=None, ready_seconds=None, cpu=None, age=0.0, clients=1, round_trip=None, masks=masks,
    )  # fmt: skip
    monkeypatch.setattr(cloud, "running", [view])


async def listed(client: httpx.AsyncClient, headers: dict[str, str]) -> list[str]:
    items = (await client.get("/v1/maps/house/versions", headers=headers)).json()["items"]
    return [one["version"] for one in items]


async def publish_three(publish: Publish, headers: dict[str, str]) -> list[str]:
    return [(await publish(headers, image=pgm(value=value))).json()["version"] for value in (0, 100, 254)]


async def test_a_publication_removes_the_oldest_versions_beyond_the_number_to_keep(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    versions = await publish_three(publish, ann)
    assert await listed(client, ann) == versions[:0:-1]


async def test_versions_that_expire_do_not_count_for_the_quota_of_versions(
    log_in: LogIn, publish: Publish, services: Services, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    await services.accounts.change("ann", limits={"versions_per_map": 2})
    assert len(set(await publish_three(publish, ann))) == 3


@pytest.mark.parametrize("masks", [(), ("house",)])
async def test_versions_in_use_neither_expire_nor_can_be_removed(
    client: httpx.AsyncClient,
    log_in: LogIn,
    publish: Publish,
    cloud: FakeCloud,
    monkeypatch: pytest.MonkeyPatch,
    masks: tuple[str, ...],
) -> None:
    ann = await log_in("ann")
    oldest = (await publish(ann, image=pgm(value=0))).json()["version"]
    robot_on(cloud, monkeypatch, oldest, masks)
    await publish_three(publish, ann)
    assert oldest in await listed(client, ann)
    refused = await client.delete(f"/v1/maps/house/versions/{oldest}", headers=ann)
    assert "in use by robots: disconnect them first" in problem_of(refused, 409, "conflict")["detail"]


async def test_only_the_owner_and_administrators_remove_a_version_that_exists_and_is_not_current(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob, eve, admin = [await log_in(user) for user in ("ann", "bob", "eve", "admin")]
    await publish(ann, readers="bob", image=pgm(value=0))
    old, current = [(await publish(ann, image=pgm(value=value))).json()["version"] for value in (100, 254)]
    path = "/v1/maps/house/versions"
    for headers, version, status, slug in (
        (bob, old, 403, "not-permitted"),
        (eve, old, 404, "not-found"),
        (ann, current, 409, "conflict"),
        (ann, 64 * "0", 404, "not-found"),
    ):
        problem_of(await client.delete(f"{path}/{version}", headers=headers), status, slug)
    assert (await client.delete(f"{path}/{old}", headers=admin)).status_code == 204
    assert await listed(client, ann) == [current]


async def test_a_publication_succeeds_if_old_versions_cannot_be_removed(
    log_in: LogIn,
    publish: Publish,
    services: Services,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fail(*_: object) -> None:
        raise Unavailable("no node answers")

    monkeypatch.setattr(services.map_store, "remove_versions", fail)
    await publish_three(publish, await log_in("ann"))
    assert "old versions of map 'house' were not removed: no node answers" in caplog.text


async def test_all_versions_are_kept_by_default(services: Services, log_in: LogIn) -> None:
    ann = await log_in("ann")
    for value in (0, 100, 254):
        put_map(services.map_store, house(image=pgm(value=value)))
    app = create_app(dataclasses.replace(services, keep_versions=None))
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://cloud") as client:
        assert len(await listed(client, ann)) == 3
