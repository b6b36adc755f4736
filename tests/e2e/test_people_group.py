"""Robots of another make that send the people whom they see: one coordinator, one identity, also after a crash."""

import asyncio
import os
import signal
from contextlib import AsyncExitStack

import pytest

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleState, TrackedPerson
from ppaas.messages.people_msgs import People, Person
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

MAP = "foyer"
FOYER = walled_map(6.0, 4.0, [])
ROBOTS = {"guard1": Pose2D(1.0, 1.0, 0.5), "guard2": Pose2D(5.0, 1.0, 2.6)}
VISITOR = 3.0, 2.2

PERIOD = 0.1
"""Time between two messages of a robot [s]."""

STORED = 0.8
"""Time after which a person is in a checkpoint [s]."""


async def watch(robot: RobotClient, error: float) -> None:
    """Publish the visitor, with an error in x [m], until cancelled."""
    while True:
        header = Header(stamp=Time.of(epoch()), frame_id="map")
        await robot.publish("people", People(header, [Person("visitor", Point(VISITOR[0] + error, VISITOR[1]))]))
        await asyncio.sleep(PERIOD)


async def coordinator(rest: RestClient) -> tuple[int, str]:
    """Return the process id and the map version of the only coordinator."""
    containers = [one for one in await rest.items("/v1/containers") if one["kind"] == "coordinator"]
    (found,) = [one for one in containers if one["map"]["id"] == MAP]
    return found["pid"], found["map"]["version"]


def visitor(states: list[PeopleState], seconds: float = 0.0) -> TrackedPerson | None:
    """Return the person of the last state, once both robots see them as one, and for some seconds."""
    people = states[-1].people if states else []
    if len(people) != 1 or len(people[0].seen_by) != len(ROBOTS):
        return None
    return people[0] if people[0].last_seen.seconds() - people[0].first_seen.seconds() >= seconds else None


async def check_rest(rest: RestClient, states: list[PeopleState], person: int) -> None:
    """Check that a person is shown, named and counted over REST."""
    people = f"/v1/maps/{MAP}/people"
    shown = await rest.get(people)
    assert (shown["coordinator"], [one["id"] for one in shown["people"]]) == ("ready", [person])
    assert {robot["robot"] for robot in shown["robots"]} == set(ROBOTS)
    await rest.patch(f"{people}/settings", {"history": True, "names": {str(person): "Zoë"}})
    await until(lambda: [one.name for one in states[-1].people] == ["Zoë"])
    counts = await rest.items(f"{people}/history")
    assert [(one["zone"], one["people"]) for one in counts] == [("", 1)]
    await rest.delete(f"{people}/history")


async def _seen_again(states: list[PeopleState]) -> tuple[int, Time]:
    """Return the identity of the visitor, and the time that both robots saw them first, in a state that is to come."""
    states.clear()
    await until(lambda: visitor(states))
    person = visitor(states)
    assert person is not None
    return person.id, person.first_seen


async def test_two_robots_see_one_person_whose_identity_outlives_the_coordinator(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, MAP, FOYER)
    async with AsyncExitStack() as stack:
        states: list[PeopleState] = []
        watching = []
        for number, (name, pose) in enumerate(ROBOTS.items()):
            file = RobotFile(
                map=MAP, initial_pose=(pose.x, pose.y, pose.theta), cores=0.25, parameters={"people_tracker": {}}
            )
            await rest.put_robot(name, file)
            drive = await stack.enter_async_context(driving(cloud.url, str(rest.token), name, FOYER, pose))
            watching.append(asyncio.create_task(watch(drive.robot, 0.1 * number)))
            stack.callback(watching[-1].cancel)
        await drive.operator.subscribe("people_coordinator/state", PeopleState, states.append)
        await until(lambda: visitor(states, STORED))
        before = visitor(states)
        assert before is not None and states[-1].count == 1
        assert {frame.partition("/")[0] for frame in before.seen_by} == set(ROBOTS)
        killed, version = await coordinator(rest)
        os.kill(killed, signal.SIGKILL)
        assert await _seen_again(states) == (before.id, before.first_seen)
        replaced, _ = await coordinator(rest)
        assert replaced != killed
        await publish_map(rest, MAP, walled_map(6.0, 4.0, [(0.2, 3.0, 1.0, 3.8)]))
        assert await _seen_again(states) == (before.id, before.first_seen)
        pid, follows = await coordinator(rest)
        assert pid == replaced and follows != version
        await check_rest(rest, states, before.id)
