"""State of a robot in lists of robots, as commands and the dashboard show it: one reading of what is known of it."""

from typing import Literal

from pydantic import Field

from endpoints.rest.schemas import ResponseBody, Triple
from endpoints.sharing.access import GOALS, LOCALIZATION, in_words, may_hear
from engine.control.views import ReportedRobot
from engine.rights.access import Access
from engine.specs.robot_report import StateReport
from ppaas.clock import epoch
from ppaas.docking.watch import is_well
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes import topics

PresentState = Literal["offline", "starting", "no signal", "online"]

SILENCE = 5.0
"""Age of the last pose from which a connected robot has no signal [s]; containers report once a second."""

_POSE, _BATTERY = (topics.AMCL_POSE.name,), ("battery_state",)

# By the numbers of actionlib_msgs/GoalStatus.
_ERRORS: dict[int | None, str] = {Status.ABORTED: "gave up", Status.REJECTED: "refused", Status.LOST: "lost"}
_ENDS: dict[int | None, str] = {Status.PREEMPTED: "stopped", Status.RECALLED: "stopped", Status.SUCCEEDED: "arrived"}
_BESIDE_DRIVING: dict[int | None, str] = {
    Status.PENDING: "Its goal waits to begin", Status.PREEMPTING: "Stopping", Status.RECALLING: "Stopping",
}  # fmt: skip


class RobotStatus(ResponseBody):
    """State of a robot; null where it is not known, or the caller may not know it."""

    connected: bool | None = Field(
        description="Whether the robot's own socket is open at an endpoint; null while no master answers"
    )
    state: PresentState | None = Field(
        None,
        description="`offline` while it is not connected, `starting` while its container starts, `online` while poses "
        "of it come, else `no signal`; null while no master answers",
    )
    battery: float | None = Field(
        None, description="Charge from 0 to 1, as the robot publishes it on `battery_state`; null if it does not"
    )
    seen_ago: float | None = Field(
        None,
        description="Time since it was last seen [s]: 0 while it is online, else since its last pose or the end of its "
        "connection; null if the cloud has not seen it since it was started",
    )
    task: str | None = Field(
        None, description=f"What it does, in words; null if the caller may not read {in_words(GOALS)}"
    )
    error: str | None = Field(
        None,
        description="What is wrong, in words: why its last goal failed, or its pose is not renewed; empty if nothing "
        f"is; null if the caller may not read {in_words(GOALS)} or {in_words(LOCALIZATION)}",
    )
    machine: str | None = Field(None, description="Machine on which its container runs; null without one")
    software: str | None = Field(
        None, description="Software of its client, as that names it when it connects; null if it does not"
    )
    pose: Triple | None = Field(None, description="Last estimated pose in the frame of its map; null without any")


def status_of(view: ReportedRobot | None, access: Access, stopped: str | None = None) -> RobotStatus:
    """Return the state of a robot as a caller may read it; without a view nothing is known.

    ``stopped`` are the stops that apply, in words.
    """
    if view is None:
        return RobotStatus.model_validate({"connected": None})
    now, report = epoch(), view.report
    state = _state(view, now)
    may_read_goals, may_read_faults = may_hear(access, GOALS), may_hear(access, LOCALIZATION)
    return RobotStatus(
        connected=view.connected,
        state=state,
        battery=report.battery if may_hear(access, _BATTERY) else None,
        seen_ago=_seen_ago(view, state, now),
        task=_task(report, state, stopped) if may_read_goals else None,
        error=_error(report) if may_read_goals and may_read_faults else None,
        machine=view.machine or None,
        software=report.software or None,
        pose=list(report.pose) if report.pose is not None and may_hear(access, _POSE) else None,
    )


def _state(view: ReportedRobot, now: float) -> PresentState:
    if not view.connected:
        return "offline"
    if view.container != "ready":
        return "starting"
    seen = view.report.pose_at
    return "online" if seen is not None and now - seen <= SILENCE else "no signal"


def _seen_ago(view: ReportedRobot, state: PresentState, now: float) -> float | None:
    if state == "online":
        return 0.0
    seen = [at for at in (view.report.pose_at, view.disconnected_since) if at is not None]
    return max(0.0, now - max(seen)) if seen else None


def _task(report: StateReport, state: PresentState, stopped: str | None) -> str:
    """Return what a robot does: nothing while it is away, or has failed."""
    if stopped:
        return stopped[0].upper() + stopped[1:]
    if state in ("offline", "starting") or report.goal in _ERRORS:
        return ""
    if report.frontiers is not None:
        return f"Exploring, {report.frontiers} frontier{'' if report.frontiers == 1 else 's'} left"
    if report.goal in _BESIDE_DRIVING:
        return _BESIDE_DRIVING[report.goal]
    return _at_dock(report) or report.goal_text or _without_reason(report)


def _at_dock(report: StateReport) -> str:
    """Return at which dock a robot without a goal stands, or what it carries; empty if neither, or not charged."""
    stands = report.goal is None or report.goal in _ENDS
    return report.docked[0].upper() + report.docked[1:] if stands and is_well(report.docked) else ""


def _without_reason(report: StateReport) -> str:
    if report.goal is None:
        return "Ready"
    if report.goal in _ENDS:
        return f"Goal: {_ENDS[report.goal]}"
    return "Driving" if report.left is None else f"Driving, {report.left:.1f} m to go"


def _error(report: StateReport) -> str:
    if report.goal in _ERRORS:
        return report.goal_text or f"Goal: {_ERRORS[report.goal]}"
    return report.docked if report.docked and not is_well(report.docked) else report.localization
