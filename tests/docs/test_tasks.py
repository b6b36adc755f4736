"""Fields, states and numbers of tasks.md are those of the code."""

import asyncio
import re
from pathlib import Path
from typing import get_args

import pytest

from endpoints.rest import task_estimates, tasks
from endpoints.rest.task_schemas import TaskFile
from engine.control.tasks import group, measuring
from ppaas.energy import battery
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridMap
from ppaas.tasks import assignment, chargers, charging, dispatcher, options, reach, records
from robots.client.cloud_url import path_of
from robots.client.robot_file import RobotFile, load_robot_file
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.documents import blocks, run_shell, table, text_of
from tests.support.waiting import patience

PAGE = "docs/tasks.md"


def test_fields_and_states_are_those_of_the_code() -> None:
    fields = {row[0]: row[1] for row in table(PAGE, "field", "meaning")}
    assert set(fields) == set(TaskFile.model_fields)
    assert f"up to {records.MOST_PLACES} places" in fields["kind"]
    assert f"up to {records.MOST_ROUNDS};" in fields["rounds"]
    assert f"up to {options.MOST_BEFORE} " in fields["after"]
    assert f"−{records.MOST_PRIORITY} to {records.MOST_PRIORITY};" in fields["priority"]
    assert {row[0] for row in table(PAGE, "state", "meaning")} == set(get_args(records.TaskState))


def test_numbers_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    for said in (
        f"You may have {tasks.MOST_OPEN} tasks",
        f"kept for {group.KEPT_FOR / 86400:g} days, at most the last {group.MOST_ENDED}",
        f"does not answer within {measuring.TIMEOUT:g} s",
        f"a change of floors as {reach.RIDE / reach.SPEED:g} s",
        f"count as {reach.RIDE:g} m farther",
        f"after {dispatcher.MOST_FAILURES}, the task",
        f"by a speed of {reach.SPEED:g} m/s",
        f"worth {assignment.PRIORITY:g} s of driving. A task that has waited for {assignment.PRIORITY:g} s",
        f"in the {assignment.URGENT:g} s before its deadline",
        f"saves {assignment.MARGIN:g} s of driving",
        f"no task for {dispatcher.REST:g} s",
        f"not connected for {dispatcher.GONE_AFTER:g} s",
        f"After {dispatcher.MOST_FAILURES} failures",
        f"charger with {100 * reach.RESERVE:g} % left",
        f"over windows of {battery.WINDOW:g} s",
        f"a metre costs {100 * battery.PER_METRE:g} % and a second {100 * battery.PER_SECOND:g} %",
        f"below {100 * charging.LOW:g} % without a task",
        f"charge below {100 * charging.OPPORTUNE:g} % if",
        f"below {100 * charging.ALMOST_FULL:g} % while",
        f"leaves at {100 * charging.FULL:g} %, and from {100 * charging.ALMOST_FULL:g} % if others",
        f"from {100 * charging.ENOUGH:g} % for a task that has waited for {charging.PATIENCE:g} s",
        f"rise by {100 * chargers.RISE:g} % in {chargers.STALLED / 60:g} min",
        f"for {chargers.SHUNNED_FOR / 60:g} min not to this one",
        f"kept for {group.OWN_KEPT_FOR / 60.0:g} minutes after their end",
        f"and of {task_estimates.MOST_REHEARSED} others",
    ):
        assert said in text, said


@pytest.fixture
def office() -> GridMap:
    """Return the map of the examples."""
    return load_map(Path("docs/examples/office.yaml").read_bytes(), Path("docs/examples/office.pgm").read_bytes())


@pytest.fixture
def robot() -> RobotFile:
    """Return the robot of the examples."""
    return load_robot_file(Path("docs/examples/tb1.json"))


@pytest.mark.journey
async def test_tasks_over_floors_are_added_and_rehearsed_as_the_page_types_them(
    own_cloud: RunningCloud, office: GridMap, robot: RobotFile, tmp_path: Path
) -> None:
    rest = await own_cloud.admin()
    await publish_map(rest, "office", office)
    await rest.put_robot("tb1", robot)
    [commands] = [block for block in blocks(PAGE, "sh") if "upper:" in block]
    printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{commands}", tmp_path, own_cloud)
    assert re.search(r"^post +tb1 +ground → upper ", printed, re.MULTILINE), printed
    assert "2 of 2 tasks done by 1 robots" in printed
    assert (tmp_path / "house.png").stat().st_size > 1000
    [added] = await rest.items(path_of("maps", "house-1", "tasks"))
    assert (added["floors"], added["places"]) == (["ground", "upper"], [[2.0, 2.0, 0.0], [10.0, 8.0, 1.57]])


@pytest.mark.journey
async def test_a_robot_does_a_task_of_the_command_line(
    own_cloud: RunningCloud, office: GridMap, robot: RobotFile, tmp_path: Path
) -> None:
    rest = await own_cloud.admin()
    await publish_map(rest, "office", office)
    await rest.put_robot("tb1", robot)
    commands, _, _, chains, missions = blocks(PAGE, "sh")
    printed = await asyncio.to_thread(run_shell, f"export PPAAS_TOKEN={rest.token}\n{commands}", tmp_path, own_cloud)
    assert "pick_drop" in printed and "queued" in printed
    tasks_of_office = path_of("maps", "office", "tasks")
    first = (await rest.items(tasks_of_office))[0]["id"]
    more = tmp_path / "more"
    more.mkdir()
    printed = await asyncio.to_thread(
        run_shell, f"export PPAAS_TOKEN={rest.token}\n{chains.replace('TASK', first)}\n{missions}", more, own_cloud
    )
    assert re.search(r"\b[34] of 4 tasks done by 1 robots in \d+ s", printed), printed
    assert (more / "morning.png").stat().st_size > 1000
    for task in reversed(await rest.items(tasks_of_office)):  # one that waits for another goes first
        await rest.delete(path_of("maps", "office", "tasks", task["id"]))
    assert rest.token is not None
    async with driving(own_cloud.url, rest.token, "tb1", office, Pose2D(*robot.initial_pose)) as drive:
        body = {"kind": "pick_drop", "places": [[3.0, 2.0], [2.5, 2.0]], "holds": [{"confirm": True}, None]}
        task = await rest.post(tasks_of_office, body)
        path, confirmed = path_of("maps", "office", "tasks", task["id"]), 0
        async with patience(90.0):
            while task["state"] in records.OPEN:
                await asyncio.sleep(0.2)
                task = await rest.get(path)
                if task["needs_confirmation"]:
                    assert drive.scorer.error(0, Pose2D(3.0, 2.0, 0.0)) <= 0.25
                    await rest.post(f"{path}/confirm", {})
                    confirmed += 1
        assert confirmed == 1
        assert (task["state"], task["robot"], task["visited"], task["failures"]) == ("done", "tb1", 2, 0), task
        assert drive.scorer.error(0, Pose2D(2.5, 2.0, 0.0)) <= 0.25
