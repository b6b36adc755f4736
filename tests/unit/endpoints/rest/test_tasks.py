"""Tasks over REST: added, listed, shown and cancelled."""

from typing import Any

import httpx
import pytest
from msgspec.structs import replace

from endpoints.resources.services import Services
from endpoints.rest import tasks
from engine.control.views import ReportedRobot
from engine.specs.robot_report import StateReport
from ppaas.buildings.building import Building, Floor
from ppaas.errors import Conflict, Unavailable
from ppaas.planners.weights import NEUTRAL
from ppaas.tasks.reach import RIDE, SPEED
from ppaas.tasks.records import TaskState
from storage.buildings.records import BuildingRecord, BuildingVersion
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import robot
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


OPTIONS: dict[str, Any] = {
    "holds": [{"confirm": True, "seconds": 60.0, "charge": 0.8}],
    "weight": 12.5,
    "not_before": 1e10,
    "preempts": True,
    "repeat": {"at": [], "days": [], "zone": "UTC", "every": 60.0, "count": 2, "until": 2e10},
}


async def test_the_options_of_a_task_are_shown(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    first = await add(client, ann)
    task = await add(client, ann, after=[{"task": first["id"], "on": "failed"}], **OPTIONS)
    assert {name: task[name] for name in OPTIONS} == OPTIONS
    assert task["after"] == [{"task": first["id"], "on": "failed"}]
    assert (task["run"], task["series"], task["holding"], task["needs_confirmation"]) == (1, task["id"], None, False)


async def test_a_task_starts_at_its_first_time_of_day(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    task = await add(client, ann, repeat={"at": ["08:30"], "zone": "Europe/Berlin"})
    assert 0.0 <= task["not_before"] - task["created"] <= 86400.0 + 3600.0


async def test_tasks_and_robots_that_do_not_exist_are_not_found(client: httpx.AsyncClient, ann: dict[str, str]) -> None:
    for wrong in ({"named_robot": "tb9"}, {"after": [{"task": "t9"}]}):
        problem_of(await client.post(TASKS, headers=ann, json=GO | wrong), 404, "not-found")
    assert (await client.get(TASKS, headers=ann)).json()["items"] == []


async def test_a_task_is_confirmed_once_while_its_robot_holds(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    task = await add(client, ann, holds=[{"confirm": True}])
    confirm = f"{TASKS}/{task['id']}/confirm"
    problem_of(await client.post(confirm, headers=ann), 409, "conflict")
    kept = services.store.task("ann", "house", task["id"])
    services.store.put_task(replace(kept, task=replace(kept.task, state="active", robot="tb1", holding=7.0)))
    shown = (await client.get(f"{TASKS}/{task['id']}", headers=ann)).json()
    assert (shown["holding"], shown["visited"], shown["needs_confirmation"]) == (7.0, 1, True)
    assert (await client.post(confirm, headers=ann)).json()["needs_confirmation"] is False
    assert services.store.task("ann", "house", task["id"]).task.confirmed == 0
    assert cloud.groups_with_changed_tasks == [("ann", "house")] * 2
    problem_of(await client.post(confirm, headers=ann), 409, "conflict")
    problem_of(await client.post(f"{TASKS}/t9/confirm", headers=ann), 404, "not-found")


@pytest.fixture
def robot_at(services: Services, cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a robot of ann stand at the origin of the map."""
    services.store.put_robot(robot("tb1"))

    async def views(robots: list[tuple[str, str]]) -> list[ReportedRobot]:
        return [ReportedRobot(True, report=StateReport(pose=(0.0, 0.0, 0.0))) for _ in robots]

    monkeypatch.setattr(cloud, "robot_views", views)


@pytest.mark.usefixtures("robot_at")
async def test_the_answer_to_a_new_task_has_its_end_and_whether_its_deadline_can_be_met(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    first = await add(client, ann, places=[[3.0, 4.0]])
    assert (first["estimate"]["robot"], first["estimate"]["late"]) == ("tb1", False)
    assert first["estimate"]["finish"] == pytest.approx(first["created"] + 5.0 / SPEED)
    second = await add(client, ann, places=[[3.0, 5.0]])
    assert second["estimate"]["finish"] == pytest.approx(second["created"] + 6.0 / SPEED, abs=0.5)
    assert cloud.costs_asked == []
    cloud.path_cost = 50.0 * NEUTRAL / 0.05  # 50 m on cells of 5 cm
    places, deadline = [[0.0, 0.0], [3.0, 4.0]], second["created"] + 30.0
    late = await add(client, ann, kind="pick_drop", places=places, deadline=deadline, priority=90)
    assert late["estimate"]["late"] is True  # 50 m by the ways of the map
    soon = await add(client, ann, kind="pick_drop", places=places, deadline=deadline + 200.0, priority=100)
    assert soon["estimate"]["late"] is False
    assert soon["estimate"]["finish"] == pytest.approx(soon["created"] + 50.0 / SPEED)
    heavy = await add(client, ann, weight=5.0)
    assert heavy["estimate"] is None


@pytest.fixture
def building(services: Services) -> None:
    """Let the map be a floor of a building of ann, beside a loft."""
    floors = (Floor(name="L1", map="house"), Floor(name="L2", map="loft", elevation=3.0))
    version = BuildingVersion(number=1, building=Building(floors=floors), author="ann", created=1.0)
    services.store.put_building(BuildingRecord(user="ann", id="hq", present=version))


@pytest.mark.usefixtures("robot_at", "building")
async def test_a_task_over_floors_names_the_floor_of_each_place_and_has_an_estimate(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    over = await add(client, ann, kind="pick_drop", places=[[3, 4], [3, 4]], floors=[None, "L2"])
    assert (over["floors"], over["estimate"]["robot"]) == (["L1", "L2"], "tb1")
    assert over["estimate"]["begin"] == pytest.approx(over["created"] + 5.0 / SPEED)
    assert over["estimate"]["finish"] == pytest.approx(over["created"] + (5.0 + RIDE) / SPEED)
    kept = services.store.task("ann", "house", over["id"]).task
    assert (kept.floors, kept.home) == (("L1", "L2"), "")
    services.store.put_robot(robot("tb1", map="loft"), instead_of=services.store.robot("ann", "tb1"))
    there = await add(client, ann, places=[[3, 4]], floors=["L2"], priority=100)
    assert there["estimate"]["finish"] == pytest.approx(there["created"] + 5.0 / SPEED)
    assert (await add(client, ann))["estimate"] is None  # no robot is on the map


@pytest.mark.usefixtures("building")
async def test_floors_that_do_not_exist_are_refused(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    unknown = await client.post(TASKS, headers=ann, json=GO | {"floors": ["L3"]})
    assert "there is no floor 'L3'; the floors are L1, L2" in problem_of(unknown, 422, "invalid-building")["detail"]
    many = await client.post(TASKS, headers=ann, json=GO | {"floors": ["L1", "L2"]})
    assert "1 in all" in problem_of(many, 400, "invalid-input")["detail"]
    services.store.remove_building("ann", "hq")
    answer = await client.post(TASKS, headers=ann, json=GO | {"floors": ["L1"]})
    assert "map 'house' is no floor of a building of yours" in answer.text


@pytest.mark.usefixtures("robot_at")
async def test_a_task_whose_rehearsal_takes_long_is_added_without_an_estimate(
    client: httpx.AsyncClient, ann: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("endpoints.rest.task_estimates.LONGEST", -1.0)
    added = await add(client, ann, kind="patrol", places=[[0.0, 0.0], [3.0, 4.0]], rounds=1000)
    assert (added["state"], added["estimate"]) == ("queued", None)


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
        {"holds": [None, {"confirm": True}]},
        {"holds": [{}]},
        {"holds": [{"seconds": 0}]},
        {"weight": -1},
        {"after": [{"task": "t", "on": "never"}]},
        {"repeat": {}},
        {"repeat": {"at": ["25:00"]}},
        {"repeat": {"at": ["08:00"], "zone": "Mars/Base"}},
        {"repeat": {"every": 0.1}},
        {"floors": ["L1"]},
        {"floors": [""]},
    ],
    ids=str,
)
async def test_a_task_that_makes_no_sense_is_refused(
    client: httpx.AsyncClient, ann: dict[str, str], wrong: dict[str, Any]
) -> None:
    answer = await client.post(TASKS, headers=ann, json=GO | wrong)
    assert answer.status_code in {400, 422}, answer.text
    assert (await client.get(TASKS, headers=ann)).json()["items"] == []
