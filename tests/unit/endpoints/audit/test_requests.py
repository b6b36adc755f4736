"""Audit records of REST requests and WebSockets.

Kinds of events: logins good, failed and throttled; tokens revoked; users created, changed, removed, logged out; maps
published, shared, rolled back, removed; robots put, changed, removed; machines and containers changed; sockets that
connect, are refused, disconnect; missing rights, whatever the request. Secrets that may be in a request: passwords in
bodies, tokens in headers, queries and paths, a password that was entered as a name.
"""

import json
from typing import Any

import httpx
import msgspec
import pytest

from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.resources.services import Services
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.robot_world import World, refusal
from tests.support.waiting import until
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish

JSON = {"content-type": "application/json"}
ROBOT = {"map": "house", "model": "turtlebot3_burger", "initial_pose": [1, 1, 0]}


def events(services: Services, **sought: Any) -> list[AuditEvent]:
    """Return the events, oldest first."""
    return services.audit.read(AuditQuery(**sought), limit=1000)[::-1]


def last(services: Services) -> AuditEvent:
    return events(services)[-1]


def summary(event: AuditEvent) -> tuple[str | None, str, str | None, str, str | None]:
    return event.user, event.action, event.object, event.outcome, event.reason


async def test_a_good_login_names_user_token_and_address(client: httpx.AsyncClient, services: Services) -> None:
    await services.accounts.register("ann", PASSWORD)
    answer = await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD})
    event = last(services)
    assert summary(event) == ("ann", "log_in", "users/ann", "ok", None)
    assert event.token == answer.json()["id"][:12]
    assert event.address == "127.0.0.1"
    assert event.status == 201


async def test_a_failed_login_names_the_user_only_if_there_is_one(
    client: httpx.AsyncClient, services: Services
) -> None:
    await services.accounts.register("ann", PASSWORD)
    for user in ("ann", "secret of ann"):
        await client.post("/v1/tokens", json={"user": user, "password": "wrong password"})
    assert [summary(event) for event in events(services, action="log_in")] == [
        (None, "log_in", "users/ann", "refused", "not-authenticated"),
        (None, "log_in", "users/(unknown)", "refused", "not-authenticated"),
    ]


async def test_a_throttled_login_is_recorded(client: httpx.AsyncClient, services: Services) -> None:
    await services.accounts.register("ann", PASSWORD)
    for _ in range(12):
        await client.post("/v1/tokens", json={"user": "ann", "password": "wrong password"})
    assert summary(last(services)) == (None, "log_in", "users/ann", "refused", "too-many-attempts")


async def test_changes_of_users_are_recorded_without_passwords(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    admin = await log_in("admin")
    await client.post("/v1/users", headers=admin, json={"id": "bob", "password": "hunter2hunter2"})
    await client.patch(
        "/v1/users/bob",
        headers=admin,
        json={"role": "admin", "password": "hunter3hunter3", "limits": {"robots": 3}},
    )
    await client.delete("/v1/users/bob/sessions", headers=admin)
    await client.delete("/v1/users/bob", headers=admin)
    found = events(services, user="admin")
    assert [(event.action, event.object, event.outcome) for event in found] == [
        ("create_user", "users/bob", "ok"),
        ("change_user", "users/bob", "ok"),
        ("end_sessions", "users/bob", "ok"),
        ("remove_user", "users/bob", "ok"),
    ]
    assert found[0].details == {"id": "bob", "role": "user"} or found[0].details == {"id": "bob"}
    assert found[1].details == {"role": "admin", "password": "(changed)", "limits": {"robots": 3}}
    assert b"hunter" not in msgspec.json.encode(events(services))


async def test_the_user_of_the_path_me_is_named(client: httpx.AsyncClient, services: Services, log_in: LogIn) -> None:
    change = {"old_password": PASSWORD, "password": "another password"}
    await client.patch("/v1/users/me", headers=await log_in("ann"), json=change)
    assert summary(last(services)) == ("ann", "change_user", "users/ann", "ok", None)
    assert last(services).details == {"password": "(changed)"}


async def test_changes_of_maps_are_recorded(
    client: httpx.AsyncClient, services: Services, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    version = (await publish(ann)).json()["version"]
    await client.patch("/v1/maps/house", headers=ann, json={"readers": ["bob"]})
    await client.post("/v1/maps/house/roll_back", headers=ann, json={"version": version, "message": "as it was"})
    await client.delete("/v1/maps/house", headers=ann)
    found = events(services, user="ann")
    assert [(event.action, event.object) for event in found] == [
        ("publish_map", "maps/house"),
        ("change_map", "maps/house"),
        ("roll_back_map", "maps/house"),
        ("remove_map", "maps/house"),
    ]
    assert found[0].details["version"] == version
    assert found[1].details == {"readers": ["bob"]}


async def test_changes_of_robots_machines_and_containers_are_recorded(
    client: httpx.AsyncClient, services: Services, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    admin = await log_in("admin")
    await publish(admin)
    await client.put("/v1/robots/tb1", headers=admin, json=ROBOT)
    await client.patch("/v1/robots/tb1", headers=admin, json={"cores": 0.5})
    await client.delete("/v1/robots/tb1", headers=admin)
    cloud.running = [container()]
    await client.patch("/v1/containers/c1", headers=admin, json={"cores": 2.0})
    await client.delete("/v1/containers/c1", headers=admin)
    await client.patch("/v1/machines/m1", headers=admin, json={"draining": True})
    await client.delete("/v1/machines/m1?force=true", headers=admin)
    await client.post("/v1/machines/m1/admit", headers=admin)
    found = events(services, user="admin")[1:]
    assert [(event.action, event.object, event.outcome) for event in found] == [
        ("put_robot", "robots/tb1", "ok"),
        ("change_robot", "robots/tb1", "ok"),
        ("remove_robot", "robots/tb1", "ok"),
        ("resize_container", "containers/c1", "ok"),
        ("give_up_container", "containers/c1", "ok"),
        ("change_machine", "machines/m1", "ok"),
        ("remove_machine", "machines/m1", "ok"),
        ("admit_machine", "machines/m1", "ok"),
    ]
    assert found[1].details == {"cores": 0.5}


async def test_a_missing_right_is_recorded_also_if_nothing_would_change(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    ann = await log_in("ann")
    await client.get("/v1/machines", headers=ann)
    assert summary(last(services)) == ("ann", "list_machines", "machines", "refused", "not-permitted")
    await client.get("/v1/maps", headers={"Authorization": "Bearer ppaas_guess"})
    assert summary(last(services)) == (None, "list_maps", "maps", "refused", "not-authenticated")


async def test_what_reads_or_computes_is_not_recorded(
    client: httpx.AsyncClient, services: Services, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    before = len(events(services))
    await client.get("/v1/maps", headers=ann)
    plan = {"start": [1, 1], "goal": [2, 2]}
    assert (await client.post("/v1/maps/house/plans", headers=ann, json=plan)).status_code == 201
    assert (await client.post("/v1/maps/house/plans?", headers=ann, json=plan)).status_code == 201
    assert (await client.get("/v1/nowhere", headers=ann)).status_code == 404
    assert (await client.post("/v1/tickets", headers=ann)).status_code == 201  # its connection is recorded
    assert len(events(services)) == before


async def test_a_failure_of_the_cloud_is_no_refusal(
    client: httpx.AsyncClient,
    services: Services,
    log_in: LogIn,
    publish: Publish,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 201

    def broken(*_arguments: object, **_options: object) -> None:
        raise RuntimeError

    monkeypatch.setattr(services.store, "remove_robot", broken)
    assert (await client.delete("/v1/robots/tb1", headers=ann)).status_code == 500
    assert summary(last(services)) == ("ann", "remove_robot", "robots/tb1", "failed", "internal-error")


async def test_no_token_is_recorded_wherever_it_is_given(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    ann = await log_in("ann")
    token = ann["Authorization"].removeprefix("Bearer ")
    await client.delete(f"/v1/tokens/{token}", headers=ann)
    await client.delete(f"/v1/robots/{token}?token={token}")
    await client.patch("/v1/maps/house", headers=ann, json={"readers": [token], "description": token})
    await client.delete("/v1/tokens/current", headers=ann)
    assert last(services).object == f"tokens/{last(services).token}"
    assert token.encode() not in msgspec.json.encode(events(services))


async def test_texts_of_clients_are_bounded_and_have_no_control_characters(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    ann = await log_in("ann")
    body = json.dumps({"description": "a\n\x1b[2J\ud800" + "b" * 900})
    await client.patch("/v1/maps/house", headers=ann | JSON, content=body)
    text = last(services).details["description"]
    assert text.startswith("a  [2J")
    assert len(text) == 100


async def test_sockets_of_robots_and_operators_are_recorded(world: World) -> None:
    async with world.robot():
        connected = last(world.services)
        assert summary(connected) == ("ann", "connect", "robots/tb1", "ok", None)
        assert connected.details == {"role": "robot"}
        assert connected.address == "127.0.0.1"
        async with world.connected("operator"):
            assert last(world.services).details == {"role": "operator"}
    await until(lambda: len(events(world.services, action="disconnect")) == 2)
    left = last(world.services)
    assert summary(left) == ("ann", "disconnect", "robots/tb1", "ok", None)
    assert left.details["code"] == 1000
    assert left.details["seconds"] >= 0.0


async def test_a_refused_socket_is_recorded_with_its_reason(world: World) -> None:
    await refusal(world.url(robot="tb9"))
    assert summary(last(world.services)) == ("ann", "connect", "robots/tb9", "refused", "not-found")
    await refusal(world.url(token="ppaas_guess"))
    assert summary(last(world.services)) == (None, "connect", "robots/tb1", "refused", "not-authenticated")
    assert "ppaas_guess" not in str(events(world.services))
