"""JSON schemas of people whom robots see."""

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, StrictBool, StrictInt

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, RequestBody, ResponseBody
from engine.control.views import PeopleGroupView
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleState, TrackedPerson
from ppaas.people.rules.registry import rule_names
from ppaas.people.settings import (
    LONGEST_RETENTION,
    MOST_CORNERS,
    MOST_TARGETS,
    MOST_ZONES,
    CountingZone,
    PeopleSettings,
)
from ppaas.plans.path_service import MAX_COORDINATE

MAX_PERSON = (1 << 53) - 1
"""Largest id of a person: the largest number that JSON programs read exactly."""

Coordinate = Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Corner = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
PersonId = Annotated[StrictInt, Field(ge=1, le=MAX_PERSON)]
PersonText = Annotated[str, Field(pattern=r"^[1-9][0-9]{0,15}$")]
PersonName = Annotated[str, Field(min_length=1, max_length=64)]
ZoneName = Annotated[str, Field(min_length=1, max_length=64, examples=["entrance"])]
# fail_fast: one error of a long list is enough.
Targets = Annotated[
    list[PersonId], Field(max_length=MOST_TARGETS, fail_fast=True, description="Ids of people to follow")
]
AtOnce = Annotated[
    StrictInt, Field(ge=0, le=MOST_TARGETS, description="Largest number of people who are followed at once")
]
Hours = Annotated[Number, Field(gt=0.0, le=LONGEST_RETENTION, description="Time for which counts are kept [h]")]
History = Annotated[StrictBool, Field(description="Whether people are counted by hour and zone; numbers only")]
Point = tuple[float, float]


class ZoneFile(RequestBody):
    """Zone in which people are counted."""

    name: ZoneName
    corners: list[Corner] = Field(
        min_length=3, max_length=MOST_CORNERS, fail_fast=True, description="Polygon, x, y [m] in the frame of the map"
    )


Zones = Annotated[list[ZoneFile], Field(max_length=MOST_ZONES, fail_fast=True)]
Rule = Annotated[Name, Field(description="Rule that chooses whom to follow: `nearest`, `named`, `longest_seen`")]


class PeopleSettingsFile(RequestBody):
    """Settings of the people of a map; omitted fields have their defaults."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"rule": "longest_seen", "history": True}]})

    rule: Rule = "nearest"
    targets: Targets = Field([])
    followed_at_once: AtOnce = 1
    names: dict[PersonText, PersonName] = Field({}, max_length=MOST_TARGETS, description="Names of people, by id")
    zones: Zones = Field([])
    history: History = False
    retention_hours: Hours = PeopleSettings().retention_hours

    def settings(self) -> PeopleSettings:
        """Return the settings; ``InvalidInput`` if two zones have the same name."""
        fields = self.model_dump()
        zones = [CountingZone(zone["name"], [(x, y) for x, y in zone["corners"]]) for zone in fields["zones"]]
        return PeopleSettings(**fields | {"zones": zones})


class PeopleSettingsChange(RequestBody):
    """Changes of settings (JSON merge patch): omitted fields stay unchanged, null restores the default."""

    rule: Rule | None = None
    targets: Targets | None = None
    followed_at_once: AtOnce | None = None
    names: Annotated[dict[PersonText, PersonName | None], Field(max_length=MOST_TARGETS)] | None = None
    zones: Zones | None = None
    history: History | None = None
    retention_hours: Hours | None = None


class ZoneAnswer(ResponseBody):
    """Zone in which people are counted."""

    name: str
    corners: list[Point]


class PeopleSettingsAnswer(ResponseBody):
    """Settings of the people of a map."""

    rule: str
    targets: list[int]
    followed_at_once: int
    names: dict[str, str]
    zones: list[ZoneAnswer]
    history: bool
    retention_hours: float


class PersonAnswer(ResponseBody):
    """Person whom robots see, or have just seen."""

    id: int
    name: str = Field(description="Name that a user gave; empty without one")
    position: Point = Field(description="x, y [m] in the frame of the map")
    velocity: Point = Field(description="[m/s]")
    covariance: list[float] = Field(description="Covariance of the position, 2 × 2, row by row [m²]")
    state: str = Field(description="`seen`; `predicted` while hidden; `lost`, hidden for too long to be counted")
    seen_by: list[str] = Field(description="tf frames of the person, `ROBOT/TORSO`")
    first_seen: float = Field(description="[s since the epoch]")
    last_seen: float = Field(description="[s since the epoch]")
    group: int = Field(description="Number of the group of people who talk; 0 for none")

    @classmethod
    def of(cls, person: TrackedPerson) -> "PersonAnswer":
        """Return a person as JSON."""
        return cls(
            id=person.id,
            name=person.name,
            position=(person.position.x, person.position.y),
            velocity=(person.velocity.x, person.velocity.y),
            covariance=person.covariance,
            state=person.state,
            seen_by=person.seen_by,
            first_seen=person.first_seen.seconds(),
            last_seen=person.last_seen.seconds(),
            group=person.group,
        )


class FollowAnswer(ResponseBody):
    """Robot that follows a person."""

    robot: str
    person: int
    cost: float | None = Field(description="Cost of the shortest path from the robot to the person; null without one")
    since: float = Field(description="[s since the epoch]")
    reason: str = Field(description="Why this robot follows this person")

    @classmethod
    def of(cls, order: FollowOrder) -> "FollowAnswer":
        """Return an order as JSON."""
        cost = order.cost if order.cost < float("inf") else None
        return cls(robot=order.robot, person=order.person, cost=cost, since=order.since.seconds(), reason=order.reason)


class PeopleRobotAnswer(ResponseBody):
    """Robot of the group."""

    robot: str
    position: Point | None = Field(description="x, y [m] in the frame of the map; null before its first report")
    deviation: float | None = Field(description="Largest deviation of its position [m]; null before its first report")
    sees: int = Field(description="Number of people whom it sees")
    trusted: bool = Field(description="Whether its reports are used")
    reason: str = Field(description="Why they are not used; empty if they are")

    @classmethod
    def of(cls, robot: GroupRobot) -> "PeopleRobotAnswer":
        """Return a robot as JSON."""
        position = robot.position.x, robot.position.y
        deviation = robot.deviation if robot.deviation < float("inf") else None
        return cls(
            robot=robot.robot,
            position=position,
            deviation=deviation,
            sees=robot.sees,
            trusted=robot.trusted,
            reason=robot.reason,
        )

    @classmethod
    def silent(cls, robot: str) -> "PeopleRobotAnswer":
        """Return a robot that has not reported yet."""
        return cls(robot=robot, position=None, deviation=None, sees=0, trusted=True, reason="")


class PeopleAnswer(ResponseBody):
    """People on a map, and the robots that follow them."""

    map: str
    coordinator: Literal["none", "refused", "starting", "ready"] = Field(
        description="State of the coordinator; `none` while no robot of the caller tracks people on the map"
    )
    reason: str = Field(description="Why there is no coordinator; empty if there is one")
    at: float | None = Field(description="Time of the positions [s since the epoch]; null without a coordinator")
    count: int = Field(description="Number of different people whom robots see now")
    rule: str = Field(description="Rule that chooses whom to follow")
    rules: list[str] = Field(description="Names of the installed rules")
    people: list[PersonAnswer]
    following: list[FollowAnswer]
    robots: list[PeopleRobotAnswer]

    @classmethod
    def without(cls, map_id: str, group: PeopleGroupView | None, rule: str, reason: str = "") -> "PeopleAnswer":
        """Return the answer of a group whose coordinator is not ready; ``group`` is None if no robot is connected."""
        robots = [] if group is None else [PeopleRobotAnswer.silent(robot) for robot in group.robots]
        fields: dict[str, Any] = {"coordinator": "none", "reason": "no robot tracks people on this map now"}
        if group is not None:
            state = "starting" if group.state == "ready" else group.state
            fields = {"coordinator": state, "reason": reason or group.reason}
        return cls(
            map=map_id,
            at=None,
            count=0,
            rule=rule,
            rules=list(rule_names()),
            people=[],
            following=[],
            robots=robots,
            **fields,
        )

    @classmethod
    def of(cls, map_id: str, group: PeopleGroupView, state: PeopleState) -> "PeopleAnswer":
        """Return the answer of a group whose coordinator is ready."""
        known = {robot.robot: PeopleRobotAnswer.of(robot) for robot in state.robots}
        silent = {robot: PeopleRobotAnswer.silent(robot) for robot in group.robots}
        return cls(
            map=map_id,
            coordinator="ready",
            reason="",
            at=state.header.stamp.seconds(),
            count=state.count,
            rule=state.rule,
            rules=list(rule_names()),
            people=[PersonAnswer.of(person) for person in state.people],
            following=[FollowAnswer.of(order) for order in state.orders],
            robots=[robot for _, robot in sorted((silent | known).items())],
        )


class FollowRequest(RequestBody):
    """People whom robots are to follow."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"people": [3]}]})

    people: list[PersonId | PersonName] = Field(
        max_length=MOST_TARGETS,
        fail_fast=True,
        description="Ids or names, each followed by one robot; an empty list: nobody",
    )


class CountAnswer(ResponseBody):
    """Number of different people in a zone in one hour."""

    hour: int = Field(description="Start of the hour [s since the epoch]")
    zone: str = Field(description="Name of the zone; empty for the whole map")
    people: int
