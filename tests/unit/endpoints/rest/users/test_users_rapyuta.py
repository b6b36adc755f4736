"""Password for robots of Rapyuta in the changes of users."""

import hashlib

import httpx

from endpoints.audit.event import AuditQuery
from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import PASSWORD, LogIn

ROBOTS = "battery staple"


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
