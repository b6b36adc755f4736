"""Robots that are removed and made again with the same id."""

from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from endpoints.services.services import Services
from ppaas.clock import epoch
from ppaas.errors import NotAuthenticated, NotFound
from storage.recordings.folder import RecordingsFolder
from storage.sharing_records import Share, TokenScope
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import clone, plan, robot
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.fixture
def services(services: Services, tmp_path: Path) -> Services:
    return replace(services, recordings=RecordingsFolder(tmp_path))


def recorded(services: Services) -> Path:
    assert services.recordings is not None
    folder = services.recordings.of_robot("ann", "tb1")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "x.mcap").write_bytes(b"x")
    return folder


async def test_a_robot_that_is_made_again_has_nothing_of_the_former_one(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    services.store.put_robot(robot("tb1", user="ann", shares=(Share("bob", "drive"),)))
    services.store.save_clone(clone("tb1", user="ann"))
    folder = recorded(services)
    own = (await services.accounts.issue_scoped("ann", TokenScope(("tb1",), "robot"), 1e6)).token
    all_of_them = (await services.accounts.issue_scoped("ann", TokenScope(("tb*",), "robot"), 1e6)).token
    assert (await client.delete("/v1/robots/tb1", headers=ann)).status_code == 204
    assert not folder.exists()
    with pytest.raises(NotAuthenticated):
        await services.accounts.authenticate(own)
    await services.accounts.authenticate(all_of_them)
    recorded(services)
    services.store.save_clone(clone("tb1", user="ann"))  # both of a container that ended late
    again = await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    assert again.status_code == 201
    assert not folder.exists()
    with pytest.raises(NotFound):
        services.store.clone("ann", "tb1")
    assert services.store.robot("ann", "tb1").shares == ()


async def test_a_token_that_waits_for_its_robot_stays_when_the_robot_is_made(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    token = (await services.accounts.issue_scoped("ann", TokenScope(("tb1",), "robot"), 1e6)).token
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    await services.accounts.authenticate(token)


async def test_the_file_of_a_robot_is_replaced_without_a_loss(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    services.store.save_clone(clone("tb1", user="ann"))
    folder = recorded(services)
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house", "cores": 2})).status_code == 200
    assert folder.exists()
    assert services.store.clone("ann", "tb1") == clone("tb1", user="ann")


async def test_the_plans_of_a_former_robot_are_not_shown_with_a_later_one_of_its_id(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann, eve = await log_in("ann"), await log_in("eve")
    await publish(ann)
    share = {"role": "look", "subscribe": ["*"]}
    services.store.add_plan(plan("old", user="ann", map="house", robot="tb1", created=epoch() - 60.0))
    for _ in range(2):
        assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code in (200, 201)
    await client.patch("/v1/robots/tb1", headers=ann, json={"description": "with a lamp"})
    await client.put("/v1/robots/tb1/shares/eve", headers=ann, json=share)
    services.store.add_plan(plan("new", user="ann", map="house", robot="tb1", created=epoch() + 60.0))
    listed = await client.get("/v1/maps/house/plans", headers=eve)
    assert [one["plan_id"] for one in listed.json()["items"]] == ["new"]
    problem_of(await client.get("/v1/plans/old", headers=eve), 404, "not-found")
