"""SIGKILL of the web process while a robot does a task: the next one ends it, and sends no goal twice."""

import asyncio
from pathlib import Path

import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.tasks.records import OPEN
from robots.client.cloud_url import path_of
from tests.faults.test_master_restart import ADOPTED, kill, waiting_robot
from tests.support.cloud.cloud import running_cloud
from tests.support.waiting import patience, until

pytestmark = pytest.mark.journey


async def test_a_task_is_done_once_though_the_master_was_killed(tmp_path: Path, office_map: GridMap) -> None:
    results: list[MoveBaseActionResult] = []
    with running_cloud(tmp_path, *ADOPTED) as first:
        rest = await first.admin()
        async with waiting_robot(first, rest, office_map, "worker") as (drive, wire, goal):
            places = [[goal.x, goal.y, goal.theta], [goal.x + 0.05, goal.y]]
            task = await rest.post(path_of("maps", "office", "tasks"), {"kind": "patrol", "places": places})
            await until(lambda: drive.scorer.distance(0) > 0.3, 60.0)
            kill(first, wire, tmp_path)
            with running_cloud(tmp_path, *ADOPTED) as second:
                wire.mend(second.url)
                again = await second.admin()
                await until(lambda: drive.robot.connections > 1, 60.0)
                await drive.robot.subscribe("move_base/result", MoveBaseActionResult, results.append)
                path = path_of("maps", "office", "tasks", task["id"])
                async with patience(120.0):
                    while (task := await again.get(path))["state"] in OPEN:
                        await asyncio.sleep(0.2)
                assert (task["state"], task["visited"], task["failures"]) == ("done", 2, 0), task
    goals = [result.status.goal_id.id for result in results]
    assert len(goals) == len(set(goals)), "each goal ends once"
    assert set(goals) <= {f"task-{task['id']}-{leg}-0" for leg in range(2)}, "no goal was given up"
