"""Answers of the tools, from the answers of the cloud's REST service."""

from pydantic import Field

from robots.mcp.tool import Answer

Pose = list[float]
"""x [m], y [m], yaw [rad] in the frame of the map."""


class RobotRow(Answer):
    """Robot in a list."""

    robot: str = Field(description="Name of the robot in all tools")
    map: str = ""
    state: str | None = Field(None, description="offline, starting, no signal or online")
    pose: Pose | None = Field(None, description="x [m], y [m], yaw [rad] in the frame of its map")
    battery: float | None = Field(None, description="Charge from 0 to 1")
    task: str | None = Field(None, description="What it does, in words")
    error: str | None = Field(None, description="What is wrong, in words")
    stopped: str | None = Field(None, description="Who has stopped it, when and why; null if nobody has")
    role: str = Field("", description="What the token may do with it: look, drive, administer or robot")
    description: str = ""


class RobotList(Answer):
    """Robots."""

    robots: list[RobotRow]
    more: bool = Field(description="Whether there are more robots")


class GoalShown(Answer):
    """Goal of a robot."""

    id: str
    pose: Pose
    state: str = Field(description="pending, active, succeeded, canceled, aborted, rejected or lost")
    text: str = Field("", description="Why the robot waits, or why the goal ended")
    sent: float | None = Field(None, description="[s since the epoch]")
    ended: float | None = Field(None, description="[s since the epoch]; null while it is active")


class RobotShown(Answer):
    """State of one robot."""

    robot: str
    map: str = ""
    connected: bool
    pose: Pose | None = Field(None, description="Estimated x [m], y [m], yaw [rad]; null before localization")
    pose_at: float | None = Field(None, description="Time of the pose [s since the epoch]")
    localization: str | None = Field(None, description="Why the pose is not renewed; empty if it is")
    goals: list[GoalShown] | None = Field(
        None, description="Goals that have not ended; null if the token may not see them"
    )
    stopped: str | None = Field(None, description="Who has stopped it, when and why; null if nobody has")


class MapRow(Answer):
    """Map in a list."""

    id: str
    owner: str
    description: str = ""
    version: str
    parts: list[str] = Field(description="Its files: yaml and image for a grid, octomap, posegraph, zones")


class MapList(Answer):
    """Maps."""

    maps: list[MapRow]
    more: bool = Field(description="Whether there are more maps")


class PathShown(Answer):
    """Path that a robot would take."""

    length: float = Field(description="[m]")
    poses: list[Pose] = Field(description="Poses along it, x [m], y [m], yaw [rad], at most 100, with both ends")


class TaskRow(Answer):
    """Task of a map."""

    id: str
    kind: str
    places: list[Pose]
    priority: int = 0
    state: str = Field(description="queued, assigned, active, done, failed or cancelled")
    robot: str | None = Field(None, description="Robot that does it; null while it is queued")
    visited: int = Field(0, description="Number of places that have been visited")
    reason: str = Field("", description="Why it waits again, or has failed")


class TaskList(Answer):
    """Tasks of a map."""

    tasks: list[TaskRow]
    more: bool = Field(description="Whether there are more tasks")


class Cancelled(Answer):
    """Goals that are being cancelled."""

    goals: list[GoalShown] = Field(
        description="The goal, or the goals that were active; each ends once the robot stands"
    )


class StopShown(Answer):
    """A stop in force."""

    scope: str = Field(description="robot, map or all")
    name: str
    by: str = Field(description="User who stopped it")
    since: float = Field(description="[s since the epoch]")
    reason: str = ""


class Stopped(Answer):
    """Outcome of a stop."""

    stops: list[StopShown]
    standing: list[str] = Field(description="Robots that have confirmed it")
    unconfirmed: list[str] = Field(description="Robots that have not confirmed it within 1 s")


class Released(Answer):
    """Outcome of a release."""

    released: list[StopShown] = Field(description="Empty if nothing was stopped")
    left: list[StopShown] = Field(description="Stops that still hold the robot")
