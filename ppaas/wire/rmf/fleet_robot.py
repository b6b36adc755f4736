"""Robot of a fleet of Open-RMF: requests, poses and ends of drives in, commands and states out.

::

    path:   0 ─── 1 ─── 2 = 3 ─── 4        2 and 3 are one place: the robot waits there until the time of 3
    drives: └─ through 0, 1 to 2 ┘└ to 4 ┘

A state lists the waypoints that are not reached, so RMF counts how far the robot is. Positions in requests and states
are in the frame of RMF, and in commands in the frame of our map.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.wire.rmf.level_frame import LevelFrame
from ppaas.wire.rmf.requests import FollowPath, Request, SetMode, Waypoint

NEAR = 0.15
"""Distance at which a waypoint counts as reached before a drive begins [m]."""

TURNED = 0.2
"""Difference of headings up to which they count as equal [rad]."""

SAME = 0.05
"""Distance up to which two waypoints are one place [m]."""

LONGEST_WAIT = 3600.0
"""A time further in the future belongs to another clock than ours, and is not waited for [s]."""


class RmfMode(IntEnum):
    """``mode`` of ``rmf_fleet_msgs/RobotMode``."""

    IDLE = 0
    CHARGING = 1
    MOVING = 2
    PAUSED = 3
    WAITING = 4
    EMERGENCY = 5
    ADAPTER_ERROR = 8


@dataclass(frozen=True, slots=True)
class DriveThrough:
    """Drive through poses to the last one; `FleetRobot.drive_ended` takes the end. It replaces the drive before.

    Parameters
    ----------
    number : int
    poses : tuple of Pose2D
        In the frame of our map.
    speed : float
        Speed limit [m/s]; 0 for none.
    """

    number: int
    poses: tuple[Pose2D, ...]
    speed: float


@dataclass(frozen=True, slots=True)
class EndDrive:
    """End the drive."""


RobotCommand = DriveThrough | EndDrive


@dataclass(frozen=True, slots=True)
class _Stage:
    """Part of a path up to a wait: its drive, the first waypoint of each pose, and where the next part begins."""

    drive: DriveThrough
    firsts: tuple[int, ...]
    end: int


class FleetRobot:
    """One robot.

    Parameters
    ----------
    name, model, level : str
        Its name in the fleet, its model, and the name of the level on which it drives.
    frame : LevelFrame
        Frame of RMF.

    Attributes
    ----------
    pose : Pose2D, optional
        Its pose in our map; None while it is lost. States are of robots with a pose.
    battery : float
        Charge [%].
    charging : bool
    error : str
        Why it does not follow its path; empty if it does.
    """

    def __init__(self, name: str, model: str, level: str, frame: LevelFrame) -> None:
        self.name, self.model, self.level, self._frame = name, model, level, frame
        self.pose: Pose2D | None = None
        self.battery, self.charging, self.error = 100.0, False, ""
        self._task = ""
        self._path: tuple[Waypoint, ...] = ()
        self._next = 0
        self._stage: _Stage | None = None
        self._paused: RmfMode | None = None
        self._commands: list[RobotCommand] = []
        self._drives, self._states = itertools.count(1), itertools.count(1)

    # -- in ------------------------------------------------------------------------------------------------------------

    def take(self, request: Request, now: float) -> str:
        """Take a request at the time ``now`` of RMF's clock [s]; return why it is refused, or an empty text.

        RMF repeats a request until a state has its task.
        """
        match request:
            case FollowPath(task, path) if (task, path) != (self._task, self._path):
                self._halt()
                self._task, self._path, self._next, self.error = task, path, 0, ""
                other = next((waypoint.level for waypoint in path if waypoint.level not in ("", self.level)), None)
                if other is not None:
                    self.error = f"a waypoint is on level {other!r}, and the robot on {self.level!r}"
                self.advance(now)
            case SetMode(task, RmfMode.PAUSED | RmfMode.EMERGENCY as mode):
                self._task, self._paused = task, RmfMode(mode)
                self._halt()
            case SetMode(task, RmfMode.MOVING | RmfMode.IDLE):
                self._task, self._paused = task, None
                self.advance(now)
            case SetMode(_, mode):
                return f"mode {mode} is not supported: the robot pauses (3, 5) and resumes (0, 2) alone"
        return ""

    def drive_passed(self, number: int, remaining: int) -> None:
        """Note how many poses of a drive remain."""
        stage = self._stage
        if stage is not None and stage.drive.number == number and 0 < remaining <= len(stage.firsts):
            self._next = max(self._next, stage.firsts[-remaining])

    def drive_ended(self, number: int, now: float, *, reached: bool, text: str = "") -> None:
        """Note the end of a drive; the ends of drives that were replaced are ignored."""
        stage = self._stage
        if stage is None or stage.drive.number != number:
            return
        self._stage = None
        if reached:
            self._next = stage.end
            self.advance(now)
        else:
            self.error = text or "the waypoint was not reached"

    def drive_lost(self) -> None:
        """Note that nobody knows of the drive any more; the next call of `advance` begins it again."""
        self._stage = None

    def advance(self, now: float) -> None:
        """Begin what is due: the next drive, also one that was lost, or the end of a wait."""
        if self._stage is not None or self._paused is not None or self.error or self.pose is None:
            return
        while self._next < len(self._path) and self._is_reached(self._next, now):
            self._next += 1
        if self._next < len(self._path) and not self._waits_at(self._next):
            self._stage = self._planned()
            self._commands.append(self._stage.drive)

    # -- out -----------------------------------------------------------------------------------------------------------

    def take_commands(self) -> list[RobotCommand]:
        """Return the commands since the last call."""
        commands, self._commands = self._commands, []
        return commands

    @property
    def mode(self) -> RmfMode:
        """Mode of the robot."""
        if self.error:
            return RmfMode.ADAPTER_ERROR
        if self._paused is not None:
            return self._paused
        if self._stage is not None:
            return RmfMode.MOVING
        if self._next < len(self._path):
            return RmfMode.WAITING
        return RmfMode.CHARGING if self.charging else RmfMode.IDLE

    def state(self, stamp: Mapping[str, int]) -> dict[str, Any] | None:
        """Return the ``RobotState``; None while it has no pose."""
        if self.pose is None:
            return None
        x, y, yaw = self._frame.to_rmf(self.pose)
        location = {"t": stamp, "x": x, "y": y, "yaw": yaw, "level_name": self.level}
        unlimited = {"obey_approach_speed_limit": False, "approach_speed_limit": 0.0, "index": 0}
        return {
            "name": self.name,
            "model": self.model,
            "task_id": self._task,
            "seq": next(self._states),
            "mode": {"mode": int(self.mode), "mode_request_id": 0, "performing_action": ""},
            "battery_percent": self.battery,
            "location": location | unlimited,
            "path": [waypoint.location for waypoint in self._path[self._next :]],
        }

    # -- the path ------------------------------------------------------------------------------------------------------

    def _halt(self) -> None:
        if self._stage is not None:
            self._stage = None
            self._commands.append(EndDrive())

    def _planned(self) -> _Stage:
        """Return the drive from the next waypoint to the next wait; waypoints at one place are one pose of it."""
        begin = self._next
        end = next((k for k in range(begin + 1, len(self._path)) if self._waits_at(k)), len(self._path))
        groups: list[list[int]] = []
        for index in range(begin, end):
            if groups and self._distance(index - 1, index) <= SAME:
                groups[-1].append(index)
            else:
                groups.append([index])
        poses = tuple(self._frame.from_rmf(self._path[group[-1]].pose) for group in groups)
        limits = [
            waypoint.location["approach_speed_limit"] / self._frame.scale
            for waypoint in self._path[begin:end]
            if waypoint.location["obey_approach_speed_limit"]
        ]
        drive = DriveThrough(next(self._drives), poses, min(limits, default=0.0))
        return _Stage(drive, tuple(group[0] for group in groups), end)

    def _is_reached(self, index: int, now: float) -> bool:
        if self._waits_at(index):
            return not 0.0 < self._path[index].at - now <= LONGEST_WAIT
        assert self.pose is not None
        goal = self._frame.from_rmf(self._path[index].pose)
        is_last = index == len(self._path) - 1
        return self.pose.distance_to(goal) <= NEAR and (
            not is_last or abs(wrap_angle(self.pose.theta - goal.theta)) <= TURNED
        )

    def _waits_at(self, index: int) -> bool:
        """Return whether a waypoint repeats the one before, at a later time."""
        if index == 0 or self._distance(index - 1, index) > SAME:
            return False
        before, waypoint = self._path[index - 1], self._path[index]
        return waypoint.at > before.at and abs(wrap_angle(waypoint.pose.theta - before.pose.theta)) <= TURNED

    def _distance(self, one: int, other: int) -> float:
        return self._path[one].pose.distance_to(self._path[other].pose)
