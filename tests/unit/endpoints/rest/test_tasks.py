"""Tasks over REST: added, listed, shown and cancelled."""

from typing import Any

import httpx
import pytest
from msgspec.structs import replace

from endpoints.resources.services import Services
from endpoints.rest import tasks
from ppaas.errors import Conflict, Unavailable
from ppaas.tasks.records import TaskState
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish

TASKS = "/v1/maps/house/tasks"
GO: dict[str, Any] = {"kind": "go_to", "places": [[1.0, 2.0]]}


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Return the header of a user who has published a map for all."""
    header = await log_in("ann")
    await publish(header, readers="*")
    return header


async def add(client: httpx.AsyncClient, header: dict[str, str], **fields: Any) -> dict[str, Any]:
    answer = await client.post(TASKS, headers=header, json=GO | fields)
    assert answer.status_code == 201, answer.text
    added: dict[str, Any] = answer.json()
    return added


def turn(services: Services, name: str, state: TaskState) -> None:
    """Let a task be in a state, as the master stores it."""
    kept = services.store.task("ann", "house", name)
    services.store.put_task(replace(kept, task=replace(kept.task, state=state, robot="tb1")))


async def test_an_added_task_is_shown_and_the_master_is_told(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    fields = {"kind": "patrol", "rounds": 3, "priority": -2, "deadline": 1e10, "labels": {"lift": "yes"}}
    task = await add(client, ann, places=[[1, 2], [3, 4, 0.5]], **fields)
    assert {name: task[name] for name in fields} == fields
    assert (task["state"], task["robot"], task["map"], task["visited"]) == ("queued", None, "house", 0)
    assert task["places"] == [[1.0, 2.0, 0.0], [3.0, 4.0, 0.5]]
    assert (await client.get(f"{TASKS}/{task['id']}", headers=ann)).json() == task
    assert cloud.groups_with_changed_tasks == [("ann", "house")]


async def test_tasks_are_added_and_cancelled_while_there_is_no_master(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def silent(*_: str) -> None:
        raise Unavailable("the master does not answer")

    monkeypatch.setattr(cloud.tasks, "changed", silent)
    task = await add(client, ann)
    assert (await client.delete(f"{TASKS}/{task['id']}", headers=ann)).json()["state"] == "cancelled"


async def test_tasks_are_listed_in_pages_and_by_state(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tasks, "READ_AT_ONCE", 2)
    names = [(await add(client, ann))["id"] for _ in range(5)]
    assert sorted(names, key=lambda name: name.split("-")[0]) == names
    names.sort()
    turn(services, names[1], "done")
    turn(services, names[2], "active")
    first = (await client.get(TASKS, headers=ann, params={"limit": 3})).json()
    rest = (await client.get(TASKS, headers=ann, params={"cursor": first["next"]})).json()
    assert [task["id"] for task in first["items"] + rest["items"]] == names
    assert rest["next"] is None
    for state, expected in (("active", names[2:3]), ("open", [names[0], *names[2:]]), ("failed", [])):
        found = (await client.get(TASKS, headers=ann, params={"state": state})).json()["items"]
        assert [task["id"] for task in found] == expected
    problem_of(await client.get(TASKS, headers=ann, params={"state": "lazy"}), 422, "invalid-request")


async def test_a_cancelled_task_has_ended(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    task = await add(client, ann)
    turn(services, task["id"], "active")
    answer = (await client.delete(f"{TASKS}/{task['id']}", headers=ann)).json()
    assert (answer["state"], answer["robot"]) == ("cancelled", "tb1")
    assert answer["ended"] >= answer["created"]
    assert cloud.groups_with_changed_tasks == [("ann", "house")] * 2
    detail = problem_of(await client.delete(f"{TASKS}/{task['id']}", headers=ann), 409, "conflict")["detail"]
    assert "cancelled" in detail
    problem_of(await client.delete(f"{TASKS}/t7", headers=ann), 404, "not-found")


async def test_a_task_that_changes_meanwhile_is_cancelled_all_the_same(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = await add(client, ann)
    put, left = services.store.put_task, [3]

    def contested(*arguments: Any, **options: Any) -> None:
        left[0] -= 1
        if left[0] >= 0:
            raise Conflict("changed")
        put(*arguments, **options)

    monkeypatch.setattr(services.store, "put_task", contested)
    assert (await client.delete(f"{TASKS}/{task['id']}", headers=ann)).json()["state"] == "cancelled"
    left[0] = 100
    other = "other"
    monkeypatch.setattr(services.store, "put_task", put)
    other = (await add(client, ann))["id"]
    monkeypatch.setattr(services.store, "put_task", contested)
    problem_of(await client.delete(f"{TASKS}/{other}", headers=ann), 409, "conflict")


async def test_users_see_their_own_tasks_alone(client: httpx.AsyncClient, ann: dict[str, str], log_in: LogIn) -> None:
    task, bob = await add(client, ann), await log_in("bob")
    assert (await client.get(TASKS, headers=bob)).json()["items"] == []
    problem_of(await client.get(f"{TASKS}/{task['id']}", headers=bob), 404, "not-found")
    problem_of(await client.post("/v1/maps/yard/tasks", headers=bob, json=GO), 404, "not-found")


async def test_a_user_may_have_so_many_open_tasks(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tasks, "MOST_OPEN", 2)
    first = await add(client, ann)
    await add(client, ann)
    assert "cancel some" in problem_of(await client.post(TASKS, headers=ann, json=GO), 429, "quota-exceeded")["detail"]
    turn(services, first["id"], "done")
    await add(client, ann)


@pytest.mark.parametrize(
    "wrong",
    [
        {"places": []},
        {"places": [[1, 2], [3, 4]]},
        {"kind": "pick_drop"},
        {"rounds": 2},
        {"kind": "fly"},
        {"priority": 1000},
        {"deadline": -1},
        {"labels": {"a b": "c"}},
        {"speed": 1},
    ],
    ids=str,
)
async def test_a_task_that_makes_no_sense_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], wrong: dict[str, Any]
) -> None:
    answer = await client.post(TASKS, headers=ann, json=GO | wrong)
    assert answer.status_code in {400, 422}, answer.text
    assert (await client.get(TASKS, headers=ann)).json()["items"] == []
