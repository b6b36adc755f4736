"""Users over REST."""

import hashlib

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish


async def test_an_admin_creates_lists_and_removes_users(client: httpx.AsyncClient, log_in: LogIn) -> None:
    admin = await log_in("admin")
    made = await client.post("/v1/users", headers=admin, json={"id": "ann", "password": PASSWORD})
    assert (made.status_code, made.json()) == (201, {"id": "ann", "role": "user", "groups": []})
    listed = await client.get("/v1/users", headers=admin)
    assert [(one["id"], one["role"]) for one in listed.json()["items"]] == [("admin", "admin"), ("ann", "user")]
    ann = await log_in("ann")
    assert (await client.delete("/v1/users/ann", headers=admin)).status_code == 204
    problem_of(await client.get("/v1/users/me", headers=ann), 401, "not-authenticated")
    problem_of(await client.delete("/v1/users/ann", headers=admin), 404, "not-found")


async def test_administration_requires_the_admin_role(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann = await log_in("ann")
    new = {"id": "bob", "password": PASSWORD, "role": "admin"}
    problem_of(await client.post("/v1/users", headers=ann, json=new), 403, "not-permitted")
    for path in ("/v1/users", "/v1/machines"):
        problem_of(await client.get(path, headers=ann), 403, "not-permitted")
    problem_of(await client.delete("/v1/users/ann", headers=ann), 403, "not-permitted")


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"id": "ann", "password": "short"}, (422, "invalid-request")),
        ({"id": "", "password": PASSWORD}, (422, "invalid-request")),
        ({"id": "../x", "password": PASSWORD}, (422, "invalid-request")),
        ({"id": "me", "password": PASSWORD}, (400, "invalid-input")),
        ({"id": "ann", "password": PASSWORD, "role": "king"}, (422, "invalid-request")),
        ({"id": "ann", "password": PASSWORD, "rolle": "admin"}, (422, "invalid-request")),
        ({"id": "admin", "password": PASSWORD}, (409, "conflict")),
        ([], (422, "invalid-request")),
    ],
)
async def test_an_invalid_new_user_is_refused(
    client: httpx.AsyncClient, log_in: LogIn, services: Services, body: object, expected: tuple[int, str]
) -> None:
    problem_of(await client.post("/v1/users", headers=await log_in("admin"), json=body), *expected)
    assert [user.id for user in services.store.users()] == ["admin"]


async def test_a_user_with_maps_or_running_robots_cannot_be_removed(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    await publish(ann)
    kept = problem_of(await client.delete("/v1/users/ann", headers=admin), 409, "conflict")
    assert "house" in kept["detail"]
    await client.delete("/v1/maps/house", headers=ann)
    cloud.running = [container("c1", connected=True)]
    problem_of(await client.delete("/v1/users/ann", headers=admin), 409, "conflict")
    cloud.running = [container("c1")]  # it waits for a robot that left
    assert (await client.delete("/v1/users/ann", headers=admin)).status_code == 204
    problem_of(await client.delete("/v1/users/admin", headers=admin), 409, "conflict")


async def test_a_user_with_running_robots_is_removed_by_force(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    cloud.running = [container("c1"), container("c2", user="bob")]
    assert (await client.delete("/v1/users/ann", params={"force": "true"}, headers=admin)).status_code == 204
    assert [one.id for one in cloud.running] == ["c2"]
    problem_of(await client.get("/v1/users/ann", headers=admin), 404, "not-found")


async def test_containers_end_before_their_user_is_removed_so_that_they_store_nothing_later(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    remove, running = services.store.remove_user, [container("c1", user="ann", robot=None, kind="coordinator")]
    cloud.running = running

    def removing(user: str) -> None:
        assert cloud.running == []
        cloud.running = running  # a robot that connects in between
        remove(user)

    monkeypatch.setattr(services.store, "remove_user", removing)
    assert (await client.delete("/v1/users/ann", headers=admin)).status_code == 204
    assert cloud.running == []


async def test_a_user_is_logged_out_everywhere_by_the_user_or_an_administrator(
    client: httpx.AsyncClient, log_in: LogIn, cloud: FakeCloud
) -> None:
    admin, bob = await log_in("admin"), await log_in("bob")
    tokens = [await log_in("ann"), await log_in("ann")]
    problem_of(await client.delete("/v1/users/ann/sessions", headers=bob), 403, "not-permitted")
    for caller, path in ((tokens[0], "/v1/users/me/sessions"), (admin, "/v1/users/ann/sessions")):
        cloud.running = [container("c1")]
        assert (await client.delete(path, headers=caller)).status_code == 204
        assert cloud.running == []
    for token in tokens:
        problem_of(await client.get("/v1/users/me", headers=token), 401, "not-authenticated")
    problem_of(await client.delete("/v1/users/nobody/sessions", headers=admin), 404, "not-found")


NEW = "battery staple"


# Changes of users: passwords and roles.


async def test_a_user_changes_the_password_and_other_logins_end(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    here, elsewhere = await log_in("ann"), await log_in("ann")
    change = {"password": NEW, "old_password": PASSWORD}
    assert (await client.patch("/v1/users/me", headers=here, json=change)).json()["id"] == "ann"
    assert (await client.get("/v1/users/me", headers=here)).status_code == 200
    problem_of(await client.get("/v1/users/me", headers=elsewhere), 401, "not-authenticated")
    assert await services.accounts.login("ann", NEW)
    problem_of(await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD}), 401, "not-authenticated")


async def test_a_password_change_requires_the_old_password(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    ann = await log_in("ann")
    answer = await client.patch("/v1/users/ann", headers=ann, json={"password": NEW})
    assert "old_password" in problem_of(answer, 422, "invalid-parameter")["detail"]
    answer = await client.patch("/v1/users/ann", headers=ann, json={"password": NEW, "old_password": "wrong horse"})
    problem_of(answer, 403, "not-permitted")
    assert await services.accounts.login("ann", PASSWORD)


async def test_an_administrator_sets_password_and_role_of_others(
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


async def test_users_cannot_change_roles_or_access_other_users(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann, admin = await log_in("ann"), await log_in("admin")
    problem_of(await client.patch("/v1/users/me", headers=ann, json={"role": "admin"}), 403, "not-permitted")
    for method in ("GET", "PATCH"):
        for other in ("admin", "nobody"):
            answer = await client.request(method, f"/v1/users/{other}", headers=ann, json={"password": NEW})
            problem_of(answer, 403, "not-permitted")
    problem_of(await client.patch("/v1/users/admin", headers=admin, json={"role": "user"}), 409, "conflict")
    problem_of(await client.delete("/v1/users/me", headers=admin), 409, "conflict")


ROBOTS = "battery staple"


# Password for robots of Rapyuta in the changes of users.


async def test_an_administrator_sets_and_removes_it(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    assert (await client.get("/v1/users/me", headers=ann)).json()["rapyuta"] is False
    changed = await client.patch("/v1/users/ann", headers=admin, json={"rapyuta_password": ROBOTS})
    assert changed.json()["rapyuta"] is True
    assert (await services.accounts.rapyuta.sign_in("ann", hashlib.sha256(ROBOTS.encode()).hexdigest()))[0].id == "ann"
    unchanged = await client.patch("/v1/users/ann", headers=admin, json={"limits": {"maps": 5}})
    assert unchanged.json()["rapyuta"] is True
    assert (await client.get("/v1/users/me", headers=ann)).status_code == 200  # tokens stay
    changed = await client.patch("/v1/users/ann", headers=admin, json={"rapyuta_password": None})
    assert changed.json()["rapyuta"] is False


async def test_others_may_not(client: httpx.AsyncClient, log_in: LogIn, services: Services) -> None:
    ann = await log_in("ann")
    for value in (ROBOTS, None):
        answer = await client.patch("/v1/users/me", headers=ann, json={"rapyuta_password": value})
        problem_of(answer, 403, "not-permitted")
    assert services.store.user("ann").rapyuta_hash == ""


async def test_unsuitable_passwords_are_refused(client: httpx.AsyncClient, log_in: LogIn) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    answer = await client.patch("/v1/users/ann", headers=admin, json={"rapyuta_password": PASSWORD})
    problem_of(answer, 400, "invalid-input")
    answer = await client.patch("/v1/users/ann", headers=admin, json={"rapyuta_password": "short"})
    assert answer.status_code == 422
    problem_of(await client.patch("/v1/users/me", headers=admin, json={"rapyuta_password": ROBOTS}), 409, "conflict")


async def test_the_audit_log_has_the_change_and_not_the_password(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin, _ = await log_in("admin"), await log_in("ann")
    await client.patch("/v1/users/ann", headers=admin, json={"rapyuta_password": ROBOTS})
    [event] = services.audit.read(AuditQuery(action="change_user"))
    assert event.details == {"rapyuta_password": "(changed)"}
