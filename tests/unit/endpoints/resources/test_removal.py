"""Users who are removed, over REST; tests/contracts has the removal itself, over all stores."""

from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from endpoints.resources.services import Services
from ppaas.clock import ManualClock, epoch
from ppaas.errors import NotAuthenticated, NotFound
from storage.recordings import RecordingsFolder
from storage.sharing_records import Share, TokenScope
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import clone, plan, robot
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish


async def replaced(client: httpx.AsyncClient, log_in: LogIn, clock: ManualClock) -> dict[str, str]:
    """Remove ann and create another ann; return her header."""
    admin = await log_in("admin")
    assert (await client.delete("/v1/users/ann", headers=admin)).status_code == 204
    clock.advance(60.0)
    made = await client.post("/v1/users", headers=admin, json={"id": "ann", "password": PASSWORD})
    assert made.status_code == 201
    return await log_in("ann")


async def test_a_later_user_neither_reads_nor_removes_what_the_former_one_planned(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, clock: ManualClock
) -> None:
    bob, ann = await log_in("bob"), await log_in("ann")
    await publish(bob, readers="ann")
    services.store.add_plan(plan("p1", user="ann", map="house", created=clock()))
    assert (await client.get("/v1/plans/p1", headers=ann)).status_code == 200
    ann = await replaced(client, log_in, clock)
    problem_of(await client.get("/v1/maps/house", headers=ann), 404, "not-found")
    problem_of(await client.get("/v1/plans/p1", headers=ann), 404, "not-found")
    await client.patch("/v1/maps/house", headers=bob, json={"readers": ["ann"]})
    assert (await client.get("/v1/plans/p1", headers=ann)).status_code == 200
    problem_of(await client.delete("/v1/plans/p1", headers=ann), 403, "not-permitted")
    services.store.add_plan(plan("p2", user="ann", map="house", created=clock() + 1.0))
    assert (await client.delete("/v1/plans/p2", headers=ann)).status_code == 204


async def test_a_group_ends_with_its_last_member_and_a_later_one_gets_none_of_its_robots(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin = await log_in("admin")
    for name in ("ann", "bob", "eve"):
        await log_in(name)
    services.store.put_robot(
        robot("tb9", user="bob", shares=(Share("group:crew", "drive"), Share("group:hall", "look")))
    )
    for group, members in (("crew", ["ann"]), ("hall", ["ann", "bob"])):
        await client.put(f"/v1/groups/{group}", headers=admin, json={"members": members})
    await client.patch("/v1/users/ann", headers=admin, json={"groups": []})
    assert [share.to for share in services.store.robot("bob", "tb9").shares] == ["group:hall"]


@pytest.mark.parametrize("path", ["/v1/users/me", "/v1/robots", "/v1/maps"])
async def test_a_user_whose_removal_has_begun_has_no_rights(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, path: str
) -> None:
    ann = await log_in("ann")
    await services.accounts.begin_removal("ann")
    problem_of(await client.get(path, headers=ann), 401, "not-authenticated")
    problem_of(await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD}), 401, "not-authenticated")
    admin = await log_in("admin")
    made = await client.post("/v1/users", headers=admin, json={"id": "ann", "password": PASSWORD})
    assert made.status_code == 201, "the removal is finished for it"


async def test_a_map_that_a_removed_user_publishes_at_the_same_moment_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await log_in("ann")
    known = services.usage.in_turn

    async def in_turn(user: str, *work: object, **said: object) -> object:
        await services.accounts.begin_removal("ann")
        return await known(user, *work, **said)  # type: ignore[arg-type]

    monkeypatch.setattr(services.usage, "in_turn", in_turn)
    problem_of(await publish(ann), 401, "not-authenticated")
    assert services.map_store.maps() == []


@pytest.fixture
def services(services: Services, tmp_path: Path) -> Services:
    return replace(services, recordings=RecordingsFolder(tmp_path))


def recorded(services: Services) -> Path:
    assert services.recordings is not None
    folder = services.recordings.of_robot("ann", "tb1")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "x.mcap").write_bytes(b"x")
    return folder


# Robots that are removed and made again with the same id.


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
