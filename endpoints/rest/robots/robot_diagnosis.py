"""Route of the diagnosis of a robot: what it sends, what is missing, and what to do."""

from typing import Annotated

import msgspec
from fastapi import APIRouter, Query
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from endpoints.resources.news import RobotFacts
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Looked, Provided, readable_head
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.schemas import ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.shared_robots import ReachedRobot
from ppaas.diagnosis.diagnose import diagnose
from ppaas.diagnosis.observations.facts import AbsenceFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, Level, error, worst
from ppaas.diagnosis.rules.link import ABSENT, absence
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.diagnostics.node import LONGEST
from storage.records import RobotRecord, User

# Facts about robots that are not connected, from the stores, the quotas and the machines.


async def absence_facts(services: Services, owner: User, record: RobotRecord) -> AbsenceFacts:
    """Return what would stop a robot of a user from connecting now."""
    machines = await services.cloud.machines.views()
    refused = await RobotFacts(services).last_refusal(record.user, record.id)
    return AbsenceFacts(
        robot=record.id,
        agv=_agv(record),
        refusal="" if refused is None else refused.reason,
        refused_ago=0.0 if refused is None else refused.ago,
        map_problem=await _map_problem(services, owner, record),
        quota_problem=await _quota_problem(services, record),
        cores=record.cores,
        free=tuple(machine.capacity - machine.given for machine in machines if machine.state == "ready"),
    )


def _agv(record: RobotRecord) -> str:
    """Return the AGV that a robot is by its file, as the bridge of AGVs writes it."""
    named = record.properties.get("vda5050")
    return f"{named.get('manufacturer', '?')}/{named.get('serialNumber', '?')}" if isinstance(named, dict) else ""


async def _map_problem(services: Services, owner: User, record: RobotRecord) -> str:
    if new_map_id(record.map) is not None:
        return ""
    try:
        await readable_head(services, owner, record.map)
    except PPaaSError as error:
        return str(error)
    return ""


async def _quota_problem(services: Services, record: RobotRecord) -> str:
    try:
        await services.cloud.users.check_container(record.user, record.cores)
    except QuotaExceeded as error:
        return str(error)
    return ""


router = APIRouter(prefix="/robots/{robot_id}", tags=["robots"], route_class=StrictRoute)

DEFAULT_SECONDS = 3.0
"""Time for which a robot is watched before the first answer [s]."""

Seconds = Annotated[
    float,
    Query(
        ge=0.0,
        le=LONGEST,
        allow_inf_nan=False,
        description="Time for which the robot is watched before the first answer [s]; later answers come at once",
    ),
]


class FindingAnswer(ResponseBody):
    """Finding about a robot."""

    level: Level = Field(description="`error`: the robot cannot drive with it; `ok`: a note")
    kind: str = Field(
        description="Kind of the finding, which does not change with its words", examples=["scan-missing"]
    )
    text: str = Field(description="What is the matter, in one sentence")
    advice: str = Field(description="What to do next; empty if there is nothing to do")
    topic: str = Field(description="Topic that it is about; empty for none")


class TopicAnswer(ResponseBody):
    """Topic that a robot publishes, or should."""

    name: str
    type: str = Field(description="Type by its name in ROS 1; empty if the clone does not have the topic")
    count: int = Field(description="Messages since the clone's container started")
    rate: float = Field(description="Messages a second")
    bandwidth: float = Field(description="Data rate [bytes/s]")
    size: float = Field(description="Mean size of a message [bytes]")
    silence: float | None = Field(description="Time since the last message [s]; null if none came")
    late: float | None = Field(description="Median of the time between stamp and arrival [s]; null without stamps")
    refused: int = Field(description="Messages that the clone refused while it watched the robot")


class FrameAnswer(ResponseBody):
    """Frame of a robot."""

    name: str
    parent: str
    static: bool
    silence: float = Field(description="Time since its last transform [s]")


class DiagnosisAnswer(ResponseBody):
    """Diagnosis of a robot."""

    robot: str
    connected: bool = Field(description="Whether the robot's own socket is open at an endpoint")
    level: Level = Field(description="Highest level of the findings")
    seconds: float = Field(description="Time for which the robot was watched [s]")
    findings: list[FindingAnswer] = Field(description="Worst first, and causes before their effects")
    topics: list[TopicAnswer]
    frames: list[FrameAnswer]


@router.get("/diagnosis", response_model=DiagnosisAnswer, responses=KNOWN | problems(403, 404))
async def diagnose_robot(robot: Looked, services: Provided, seconds: Seconds = DEFAULT_SECONDS) -> dict[str, object]:
    """Diagnose a robot: what it sends, what is missing, and what to do, in words.

    The clone watches the robot for some seconds before the first answer, and until half a minute after the last one.
    For a robot that is not connected, the answer says what would stop it from connecting.
    """
    findings, seen = await _diagnosis(services, robot, seconds)
    [view] = await services.cloud.robot_views([(robot.user, robot.id)])
    heard = seen.link is not None and seen.link.robots > 0  # while no master answers, the robot's container knows
    connected = heard if view is None else view.connected
    return _answer(robot.id, findings, seen, connected=connected)


async def _diagnosis(services: Services, robot: ReachedRobot, seconds: float) -> tuple[list[Finding], Observations]:
    try:
        seen = await services.cloud.nodes.observe(robot.user, robot.id, seconds)
    except Unavailable as reason:
        return await _without_clone(services, robot.record, reason), Observations(seconds=0.0)
    if seen.link is not None and not seen.link.robots:
        obstacles = [each for each in await _absence(services, robot.record) if each.kind != ABSENT]
        return [*obstacles, *diagnose(seen)], seen
    return diagnose(seen), seen


async def _without_clone(services: Services, record: RobotRecord, reason: Unavailable) -> list[Finding]:
    """Return the findings about a robot without a container: it waits for one, or is not connected at all."""
    findings = await _absence(services, record)
    containers = await services.cloud.containers.views(record.user)
    if any(one.robot == record.id and one.user == record.user for one in containers):
        findings = [error("clone-not-ready", f"The clone of the robot does not answer: {reason}", "Try again.")]
    return findings


async def _absence(services: Services, record: RobotRecord) -> list[Finding]:
    owner = await run_in_threadpool(services.store.user, record.user)
    return list(absence(await absence_facts(services, owner, record)))


def _answer(robot: str, findings: list[Finding], seen: Observations, *, connected: bool) -> dict[str, object]:
    return {
        "robot": robot,
        "connected": connected,
        "level": worst(findings),
        "seconds": seen.seconds,
        "findings": msgspec.to_builtins(findings),
        "topics": msgspec.to_builtins(seen.topics),
        "frames": [
            {"name": each.name, "parent": each.parents[-1], "static": each.static, "silence": each.silence}
            for each in seen.frames
        ],
    }
