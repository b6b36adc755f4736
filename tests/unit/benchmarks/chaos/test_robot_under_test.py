"""Robots of a chaos run stay connected until all of them have ended their goals, and so give way to each other."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator

import pytest
from websockets.asyncio.server import ServerConnection
from websockets.protocol import State

from benchmarks.chaos.message_checks import FAR, Gap, Silences, Strays
from benchmarks.chaos.robot_under_test import RobotUnderTest, end_together
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.granted_move_base.node import GIVING_WAY
from robots.sim.courses import Course
from robots.sim.world import World
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.waiting import patience, until
from tests.support.world.rooms import room

START, GOAL = Pose2D(2.0, 2.0, 0.0), Pose2D(3.0, 2.0, 0.0)


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


@pytest.fixture
def errors() -> list[str]:
    """Return the errors that robots have told."""
    return []


def robot(server: RosbridgeServer, errors: list[str], name: str = "r", *, operator: bool = False) -> RobotUnderTest:
    """Return a robot in a world of its own."""
    world = World(room(4.0, 4.0))
    address, course = (server.url, "t"), Course(START, (GOAL,), ())
    return RobotUnderTest(
        address, name, world.add_robot(START), course, errors.append, clock=world.time, operator=operator
    )


@contextlib.asynccontextmanager
async def driving(server: RosbridgeServer, *robots: RobotUnderTest) -> AsyncIterator["asyncio.Task[None]"]:
    """Let robots drive to their goals, then end their runs together; the task is that of the end."""
    async with patience(30.0), asyncio.TaskGroup() as group:
        runs = [group.create_task(each.run()) for each in robots]
        await until(lambda: len(goals_of(server)) == len(robots))
        yield group.create_task(end_together(robots))
        await asyncio.gather(*runs)


def goals_of(server: RosbridgeServer) -> list[str]:
    """Return the ids of the goals that the server has received."""
    return [frame["msg"]["goal_id"]["id"] for frame in server.of("publish") if frame["topic"] == "move_base/goal"]


async def end(server: RosbridgeServer, robot: str, goal: str) -> None:
    """Send the result of a goal to the clients of a robot."""
    status = {"goal_id": {"id": goal}, "status": int(Status.SUCCEEDED)}
    frame = {"op": "publish", "topic": "move_base/result", "msg": {"status": status}}
    for connection in open_connections(server, f"robot={robot}"):
        await connection.send(json.dumps(frame))


def open_connections(server: RosbridgeServer, query: str) -> list[ServerConnection]:
    """Return the open connections whose URL has a text in its query."""
    return [
        connection
        for connection in server.connections
        if connection.state is State.OPEN and connection.request is not None and query in connection.request.path
    ]


@pytest.mark.parametrize("operator", [False, True])
async def test_a_robot_without_goals_stays_connected_while_another_has_one(
    server: RosbridgeServer, errors: list[str], *, operator: bool
) -> None:
    first, second = robot(server, errors, "a", operator=operator), robot(server, errors, "b")
    async with driving(server, first, second) as ending:
        own, other = sorted(goals_of(server), key=lambda goal: "b-goal" in goal)
        await end(server, "a", own)
        await first.ended.wait()
        sent = len(server.frames)
        await until(lambda: len(server.frames) > sent + 50)
        assert len(open_connections(server, "role=robot")) == 2
        assert not ending.done()
        await end(server, "b", other)
    assert goals_of(server) == [own, other]
    assert errors == []


async def test_results_of_goals_by_which_a_robot_gives_way_are_not_those_of_its_goals(
    server: RosbridgeServer, errors: list[str]
) -> None:
    one = robot(server, errors)
    async with driving(server, one):
        for _ in range(2):
            await end(server, "r", f"{GIVING_WAY}1")
        await end(server, "r", "r-goal-7")
        await end(server, "r", *goals_of(server))
    assert errors == ["r received the result of a goal that it never sent: r-goal-7"]
    assert (one.sender.goals.sent, one.sender.goals.endings["result"]) == (1, 1)


def test_silences_before_between_and_after_control_cycles_are_measured() -> None:
    silences = Silences()
    silences.heard(1.0)
    silences.goal_sent(3.0)
    for now in (4.0, 4.25, 4.5, 6.5):
        silences.heard(now)
    silences.goal_ended(8.0)
    silences.heard(20.0)
    assert silences.gaps == [Gap(3.0, 4.0), Gap(4.5, 6.5), Gap(6.5, 8.0)]
    assert silences.gaps[1].seconds == pytest.approx(2.0)


def test_no_gap_is_recorded_if_all_cycles_are_received() -> None:
    silences = Silences()
    silences.goal_sent(0.0)
    for cycle in range(40):
        silences.heard(0.05 * cycle)
    silences.goal_ended(2.0)
    assert silences.gaps == []


def test_a_robot_is_astray_from_its_first_far_pose_until_the_next_near_one() -> None:
    strays = Strays()
    for now, metres in enumerate((0.1, FAR, 5.0, 0.3, 0.2, 2.0)):
        strays.look(metres, float(now))
    assert strays.gaps == [Gap(1.0, 3.0)]
    strays.end(9.0)
    strays.end(10.0)
    assert strays.gaps == [Gap(1.0, 3.0), Gap(5.0, 9.0)]
