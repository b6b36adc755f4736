"""Changes of users: passwords and roles."""

import httpx

from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import PASSWORD, LogIn

NEW = "battery staple"


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
