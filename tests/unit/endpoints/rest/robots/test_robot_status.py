"""States of robots in lists: what is read from the reports of containers, in words."""

import httpx
import pytest

from endpoints.rest.robots import robot_status
from endpoints.rest.robots.robot_status import SILENCE, status_of
from engine.control.views import ReportedRobot
from engine.protocols.robot_link import ContainerBeat
from engine.rights.access import Access
from engine.specs.robot_report import StateReport
from ppaas.messages.actionlib_msgs import Status
from storage.sharing_records import Share
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.still_place import StillRobot
from tests.unit.endpoints.conftest import LogIn, Publish

NOW = 1000.0
OWNER = Access.of_owner("tb1")


@pytest.fixture(autouse=True)
def at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_status, "epoch", lambda: NOW)


def connected(**report: object) -> ReportedRobot:
    """Return a robot that is connected, and of which a pose has just come unless the report has another time."""
    return ReportedRobot(True, None, "ready", "m1", StateReport(**({"pose_at": NOW} | report)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("view", "state", "seen"),
    [
        (ReportedRobot(False), "offline", None),
        (ReportedRobot(False, NOW - 60.0), "offline", 60.0),
        (ReportedRobot(False, NOW - 60.0, "ready", "m1", StateReport(pose_at=NOW - 90.0)), "offline", 60.0),
        (ReportedRobot(True, None, "starting", "m1"), "starting", None),
        (connected(), "online", 0.0),
        (connected(pose_at=NOW - SILENCE), "online", 0.0),
        (connected(pose_at=NOW - SILENCE - 1.0), "no signal", SILENCE + 1.0),
        (connected(pose_at=None), "no signal", None),
        (connected(pose_at=NOW + 1.0), "online", 0.0),
    ],
)
def test_a_robot_is_online_while_poses_of_it_come(view: ReportedRobot, state: str, seen: float | None) -> None:
    status = status_of(view, OWNER)
    assert (status.state, status.seen_ago, status.connected) == (state, seen, view.connected)


@pytest.mark.parametrize(
    ("report", "task", "error"),
    [
        ({}, "Ready", ""),
        ({"goal": Status.ACTIVE}, "Driving", ""),
        ({"goal": Status.ACTIVE, "left": 3.21}, "Driving, 3.2 m to go", ""),
        ({"goal": Status.ACTIVE, "left": 3.2, "goal_text": "waits for tb2"}, "waits for tb2", ""),
        ({"goal": Status.PENDING}, "Its goal waits to begin", ""),
        ({"goal": Status.PREEMPTING}, "Stopping", ""),
        ({"goal": Status.SUCCEEDED}, "Goal: arrived", ""),
        ({"goal": Status.PREEMPTED, "goal_text": "another goal came"}, "another goal came", ""),
        ({"goal": Status.ABORTED, "goal_text": "no way"}, "", "no way"),
        ({"goal": Status.REJECTED}, "", "Goal: refused"),
        ({"goal": Status.ACTIVE, "localization": "scans are refused"}, "Driving", "scans are refused"),
        ({"frontiers": 1}, "Exploring, 1 frontier left", ""),
        ({"frontiers": 3, "goal": Status.ACTIVE}, "Exploring, 3 frontiers left", ""),
        ({"goal": 42}, "Driving", ""),
        ({"docked": "docked at dock 'a'"}, "Docked at dock 'a'", ""),
        ({"goal": Status.SUCCEEDED, "docked": "docked at dock 'a'"}, "Docked at dock 'a'", ""),
        ({"goal": Status.ACTIVE, "docked": "docked at dock 'a'", "goal_text": "undocking"}, "undocking", ""),
        ({"docked": "the robot stands at dock 'a' …"}, "Ready", "the robot stands at dock 'a' …"),
    ],
)
def test_task_and_error_are_said_in_words(report: dict[str, object], task: str, error: str) -> None:
    status = status_of(connected(**report), OWNER)
    assert (status.task, status.error) == (task, error)


def test_a_robot_that_is_away_has_no_task() -> None:
    away = ReportedRobot(False, NOW, "ready", "m1", StateReport(goal=Status.ACTIVE, left=2.0))
    assert status_of(away, OWNER).task == ""


def test_battery_software_machine_and_pose_are_returned_as_they_are() -> None:
    status = status_of(connected(battery=0.8, software="acme 3.2", pose=(1.0, 2.0, 0.5)), OWNER)
    assert (status.battery, status.software, status.machine, status.pose) == (0.8, "acme 3.2", "m1", [1.0, 2.0, 0.5])
    nothing = status_of(connected(), OWNER)
    assert (nothing.battery, nothing.software, nothing.pose) == (None, None, None)


def test_nothing_is_known_while_no_master_answers() -> None:
    assert set(status_of(None, OWNER).model_dump().values()) == {None}


def test_what_a_caller_may_not_hear_is_left_out() -> None:
    looks = Access("ann:tb1", (Share("bob", "look", subscribe=("scan",)),))
    view = connected(battery=0.8, pose=(1.0, 2.0, 0.5), goal=Status.ABORTED, goal_text="no way")
    status = status_of(view, looks)
    assert (status.battery, status.pose, status.task, status.error) == (None, None, None, None)
    assert status.state == "online"


async def test_robots_are_listed_with_what_their_containers_report(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, cloud: FakeCloud
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})
    cloud.running = [container("c1", machine="m7")]
    cloud.connect("ann", "tb1", place := StillRobot())
    place.take(ContainerBeat(busy=True, robot=True, report=StateReport(pose_at=NOW, goal=Status.ACTIVE, left=4.0)))
    [listed] = (await client.get("/v1/robots", headers=ann)).json()["items"]
    said = {key: listed[key] for key in ("connected", "state", "task", "machine")}
    assert said == {"connected": True, "state": "online", "task": "Driving, 4.0 m to go", "machine": "m7"}
