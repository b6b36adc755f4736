"""What may be changed after it was made: users, tokens, maps, robots, plans, containers."""

from typing import Any

import httpx
import pytest

from endpoints.services.services import Services
from ppaas.errors import Conflict
from storage.records import RobotRecord
from tests.endpoints.conftest import PASSWORD, LogIn, Publish
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import YAML, pgm, plan, robot

NEW = "battery staple"
MERGE = {"Content-Type": "application/merge-patch+json"}


# -- users and tokens --------------------------------------------------------------------------------------------------


async def test_a_user_changes_the_own_password_with_the_old_one_and_other_logins_end(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    here, elsewhere = await log_in("ann"), await log_in("ann")
    change = {"password": NEW, "old_password": PASSWORD}
    assert (await client.patch("/v1/users/me", headers=here, json=change)).json()["id"] == "ann"
    assert (await client.get("/v1/users/me", headers=here)).status_code == 200
    problem_of(await client.get("/v1/users/me", headers=elsewhere), 401, "not-authenticated")
    assert await services.accounts.login("ann", NEW)
    problem_of(await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD}), 401, "not-authenticated")


async def test_without_the_old_password_it_stays(client: httpx.AsyncClient, log_in: LogIn, services: Services) -> None:
    ann = await log_in("ann")
    answer = await client.patch("/v1/users/ann", headers=ann, json={"password": NEW})
    assert "old_password" in problem_of(answer, 422, "invalid-parameter")["detail"]
    answer = await client.patch("/v1/users/ann", headers=ann, json={"password": NEW, "old_password": "wrong horse"})
    problem_of(answer, 403, "not-permitted")
    assert await services.accounts.login("ann", PASSWORD)


async def test_an_administrator_gives_others_a_password_and_a_role(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    changed = await client.patch("/v1/users/ann", headers=admin, json={"password": NEW, "role": "admin"})
    assert changed.json() == (await client.get("/v1/users/ann", headers=admin)).json()
    assert (changed.json()["id"], changed.json()["role"]) == ("ann", "admin")
    problem_of(await client.get("/v1/users/me", headers=ann), 401, "not-authenticated")
    again = {"Authorization": f"Bearer {await services.accounts.login('ann', NEW)}"}
    assert (await client.get("/v1/users", headers=again)).status_code == 200
    problem_of(await client.patch("/v1/users/nobody", headers=admin, json={"role": "user"}), 404, "not-found")


async def test_nobody_takes_a_role_or_looks_at_others(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann, admin = await log_in("ann"), await log_in("admin")
    problem_of(await client.patch("/v1/users/me", headers=ann, json={"role": "admin"}), 403, "not-permitted")
    for method in ("GET", "PATCH"):
        for other in ("admin", "nobody"):
            answer = await client.request(method, f"/v1/users/{other}", headers=ann, json={"password": NEW})
            problem_of(answer, 403, "not-permitted")
    problem_of(await client.patch("/v1/users/admin", headers=admin, json={"role": "user"}), 409, "conflict")
    problem_of(await client.delete("/v1/users/me", headers=admin), 409, "conflict")


async def test_tokens_are_listed_without_themselves_and_revoked_one_by_one(
    client: httpx.AsyncClient, log_in: LogIn
) -> None:
    here, elsewhere, bob = await log_in("ann"), await log_in("ann"), await log_in("bob")
    listed = (await client.get("/v1/tokens", headers=here)).json()["items"]
    assert len(listed) == 2
    assert all(one["created"] == 1_000_000.0 and one["expires"] > one["created"] for one in listed)
    assert here["Authorization"].split()[1] not in str(listed)
    [other] = [one["id"] for one in listed if not one["current"]]
    problem_of(await client.delete(f"/v1/tokens/{other}", headers=bob), 404, "not-found")
    assert (await client.delete(f"/v1/tokens/{other}", headers=here)).status_code == 204
    problem_of(await client.get("/v1/users/me", headers=elsewhere), 401, "not-authenticated")
    assert (await client.delete("/v1/tokens/current", headers=here)).status_code == 204
    problem_of(await client.get("/v1/users/me", headers=here), 401, "not-authenticated")
    assert (await client.get("/v1/users/me", headers=bob)).status_code == 200


async def test_the_id_of_a_new_token_is_that_of_the_list(client: httpx.AsyncClient, log_in: LogIn) -> None:
    await log_in("ann")
    made = (await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD})).json()
    listed = await client.get("/v1/tokens", headers={"Authorization": f"Bearer {made['token']}"})
    assert [one["id"] for one in listed.json()["items"] if one["current"]] == [made["id"]]


# -- maps --------------------------------------------------------------------------------------------------------------


async def test_the_owner_says_who_reads_a_map_and_what_it_shows(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    made = (await publish(ann, description="the ground floor")).json()
    changed = await client.patch("/v1/maps/house", headers=ann | MERGE, content='{"readers": ["bob", "bob"]}')
    assert (changed.json()["readers"], changed.json()["description"]) == (["bob"], "the ground floor")
    assert changed.json()["version"] == made["version"]
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 403, "not-permitted")
    emptied = await client.patch("/v1/maps/house", headers=ann, json={"readers": None, "description": None})
    assert (emptied.json()["readers"], emptied.json()["description"]) == ([], "")
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 404, "not-found")


@pytest.mark.parametrize(
    "change",
    [
        {"readers": ["../x"]},
        {"readers": "bob"},
        {"readers": ["u"] * 257},
        {"description": "x" * 1001},
        {"owner": "bob"},
    ],
)
async def test_what_cannot_be_said_of_a_map_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any]
) -> None:
    ann = await log_in("ann")
    before = (await publish(ann)).json()
    answer = await client.patch("/v1/maps/house", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", next(iter(change))]
    assert (await client.get("/v1/maps/house", headers=ann)).json() == before


async def test_every_version_of_a_map_is_found_again(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    first = (await publish(ann)).json()
    second = (await publish(ann, image=pgm(5, 6, 0))).json()
    path = f"/v1/maps/house/versions/{first['version']}"
    assert (await client.get(path, headers=ann)).json() == first
    assert (await client.get(f"{path}/yaml", headers=ann)).content == YAML
    image = await client.get(f"{path}/image", headers=ann)
    assert (image.content, image.headers["content-type"]) == (pgm(), "image/x-portable-graymap")
    assert (await client.get("/v1/maps/house", headers=ann)).json()["version"] == second["version"]
    for end in ("", "/yaml", "/image"):
        problem_of(await client.get(path + end, headers=bob), 404, "not-found")
        unknown = f"/v1/maps/house/versions/{'0' * 64}{end}"
        assert (
            "version of map 'house'" in problem_of(await client.get(unknown, headers=ann), 404, "not-found")["detail"]
        )


# -- robots ------------------------------------------------------------------------------------------------------------

FILE = {"map": "house", "cores": 0.25, "parameters": {"amcl": {"max_particles": 800, "min_particles": 100}}}


async def test_a_robot_is_changed_by_what_is_said_and_all_else_stays(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).json()
    assert (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).status_code == 200
    patch = '{"cores": 2, "initial_pose": [1, 2], "parameters": {"amcl": {"min_particles": null}, "move_base": {}}}'
    changed = await client.patch("/v1/robots/tb1", headers=ann | MERGE, content=patch)
    parameters = {"amcl": {"max_particles": 800}, "move_base": {}}
    assert changed.json() == made | {"cores": 2.0, "initial_pose": [1.0, 2.0, 0.0], "parameters": parameters}
    reset = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": None, "parameters": None})
    assert (reset.json()["cores"], reset.json()["parameters"]) == (1.0, {})


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"map": None}, "map"),
        ({"cores": 0}, "cores"),
        ({"colour": "red"}, "colour"),
        ({"initial_pose": [1]}, "initial_pose"),
        ({"parameters": 1}, "parameters"),
        ({"model": "../x"}, "model"),
    ],
)
async def test_a_change_that_would_break_a_robot_is_refused_and_it_stays(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, change: dict[str, Any], where: str
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    made = (await client.put("/v1/robots/tb1", headers=ann, json=FILE)).json()
    answer = await client.patch("/v1/robots/tb1", headers=ann, json=change)
    assert problem_of(answer, 422, "invalid-request")["errors"][0]["where"][:2] == ["body", where]
    assert (await client.get("/v1/robots/tb1", headers=ann)).json() == made | {"urdf": None}


async def test_a_robot_is_not_moved_to_a_map_that_its_user_may_not_read(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann, bob = await log_in("ann"), await log_in("bob")
    await publish(ann)
    await publish(bob, "secret")
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    problem_of(await client.patch("/v1/robots/tb1", headers=ann, json={"map": "secret"}), 404, "not-found")
    problem_of(await client.patch("/v1/robots/tb9", headers=ann, json={"cores": 1}), 404, "not-found")


async def test_of_two_who_change_a_robot_at_once_one_is_told_to_look_again(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json=FILE)
    put = services.store.put_robot

    def late(record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        put(robot("tb1", cores=3.0))
        return put(record, instead_of=instead_of)

    monkeypatch.setattr(services.store, "put_robot", late)
    answer = await client.patch("/v1/robots/tb1", headers=ann, json={"cores": 2})
    problem_of(answer, 409, Conflict.slug)
    assert services.store.robot("ann", "tb1").cores == 3.0


# -- plans and containers ----------------------------------------------------------------------------------------------


async def test_a_plan_is_removed_by_who_asked_for_it_the_owner_of_its_map_or_an_administrator(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    headers = {name: await log_in(name) for name in ("ann", "bob", "carl", "dora", "admin")}
    await publish(headers["ann"], readers="bob,carl")
    for plan_id in ("p1", "p2", "p3"):
        services.store.add_plan(plan(plan_id, user="bob"))
    problem_of(await client.delete("/v1/plans/p1", headers=headers["carl"]), 403, "not-permitted")
    problem_of(await client.delete("/v1/plans/p1", headers=headers["dora"]), 404, "not-found")
    for user, plan_id in (("bob", "p1"), ("ann", "p2"), ("admin", "p3")):
        assert (await client.delete(f"/v1/plans/{plan_id}", headers=headers[user])).status_code == 204
    assert services.store.plans("house") == []


async def test_a_container_is_shown_and_given_up_by_its_user(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    cloud.running = [container("c1"), container("c2")]
    ann, bob = await log_in("ann"), await log_in("bob")
    assert (await client.get("/v1/containers/c1", headers=ann)).json()["robot"] == "tb1"
    for method in ("GET", "DELETE"):
        problem_of(await client.request(method, "/v1/containers/c1", headers=bob), 404, "not-found")
    assert (await client.delete("/v1/containers/c1", headers=ann)).status_code == 202
    assert (await client.delete("/v1/containers/c2", headers=await log_in("admin"))).status_code == 202
    assert cloud.given_up == ["c1", "c2"]
    problem_of(await client.delete("/v1/containers/c1", headers=ann), 404, "not-found")
