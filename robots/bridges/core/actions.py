"""Actions of Nav2 that the clone executes, offered to the robot; goals and results of each release of ROS 2.

An action consists of three services and two topics below its name: ``_action/send_goal``, ``_action/get_result``,
``_action/cancel_goal``, ``_action/feedback`` and ``_action/status``.

Source: ROS 2 design, "Actions"; ``action_msgs``.
"""

import asyncio
import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from ppaas.wire.ros.graph import LATCHED, Qos
from ppaas.wire.ros.types import RosTypes, to_json
from robots.bridges.core.cloud_link import CloudGoal
from robots.bridges.core.parts import BridgeParts
from robots.bridges.core.transport import Closable

NAVIGATE, WAYPOINTS = "nav2_msgs/action/NavigateToPose", "nav2_msgs/action/FollowWaypoints"


def in_release(types: RosTypes, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a message of the cloud without the fields that a type lacks in a release."""
    known = {field.name for field in types.fields(name)}
    return {key: value for key, value in values.items() if key in known}


def result_of(action: str, types: RosTypes, values: Mapping[str, Any], reason: str) -> dict[str, Any]:
    """Return the result of a goal as a release has it.

    Parameters
    ----------
    action : str
        Type of the action.
    types : RosTypes
        Types of the release.
    values : mapping
        Result of the cloud; empty if it has none.
    reason : str
        Why the goal was refused or lost; empty if it has a result.
    """
    result = dict(values)
    if reason:
        result = {"error_code": 0xFFFF, "error_msg": reason}
    if action == WAYPOINTS:
        result["missed_waypoints"] = _missed(types.release, result.get("missed_waypoints", []))
    return in_release(types, f"{action}_Result", result)


def _missed(release: str, waypoints: list[dict[str, Any]]) -> list[Any]:
    if release == "humble":
        return [one["waypoint_index"] for one in waypoints]
    if release == "jazzy":
        return [
            {"index": one["waypoint_index"], "goal": one["waypoint_pose"], "error_code": one.get("error_code", 0)}
            for one in waypoints
        ]
    return waypoints


EXECUTING, CANCELING, ABORTED = 2, 3, 6
"""Statuses of ``action_msgs/GoalStatus``; the final ones 4 to 6 are the cloud's."""

REJECTED, UNKNOWN_GOAL, TERMINATED = 1, 2, 3
"""Return codes of ``action_msgs/CancelGoal``; 0 is for goals that are being cancelled."""

REFUSAL_WAIT = 0.25
"""Time for which a goal waits for the cloud's refusal before it counts as accepted [s]."""

KEPT = 100
"""Number of ended goals whose results are kept."""

GOAL_STATUSES = "action_msgs/msg/GoalStatusArray"
CANCEL = "action_msgs/srv/CancelGoal"


@dataclass(slots=True)
class _Goal:
    uuid: bytes
    stamp: dict[str, int]
    sent: CloudGoal
    heard: asyncio.Event
    done: "asyncio.Future[dict[str, Any]]"
    status: int = EXECUTING

    @property
    def info(self) -> dict[str, Any]:
        return {"goal_id": {"uuid": self.uuid}, "stamp": self.stamp}


class ActionServer:
    """One action.

    Parameters
    ----------
    name, type_name : str
        Name in the cloud, and type.
    full : str
        Name in ROS, with a leading slash.
    parts : BridgeParts
        Ends of the bridge.
    """

    def __init__(self, name: str, type_name: str, full: str, parts: BridgeParts) -> None:
        transport = parts.transport
        self._name, self._type, self._types, self._parts = name, type_name, transport.types, parts
        self._goals: dict[bytes, _Goal] = {}
        below = f"{full}/_action"
        self._feedback = transport.publisher(f"{below}/feedback", f"{type_name}_FeedbackMessage", Qos())
        self._status = transport.publisher(f"{below}/status", GOAL_STATUSES, LATCHED)
        self._served: list[Closable] = [
            self._feedback,
            self._status,
            transport.serve(f"{below}/send_goal", f"{type_name}_SendGoal", self._send_goal),
            transport.serve(f"{below}/get_result", f"{type_name}_GetResult", self._get_result),
            transport.serve(f"{below}/cancel_goal", CANCEL, self._cancel_goal),
        ]
        self._publish_status()

    def close(self) -> None:
        """Withdraw the action."""
        for part in self._served:
            part.close()

    # -- services ------------------------------------------------------------------------------------------------------

    async def _send_goal(self, request: bytes) -> bytes:
        kind = f"{self._type}_SendGoal"
        values = self._types.decode(f"{kind}_Request", request)
        uuid, stamp = values["goal_id"]["uuid"], self._parts.time.now()
        accepted = uuid not in self._goals and await self._accept(uuid, stamp, to_json(values["goal"]))
        return self._types.encode(f"{kind}_Response", {"accepted": accepted, "stamp": stamp})

    async def _accept(self, uuid: bytes, stamp: dict[str, int], goal: bytes) -> bool:
        heard = asyncio.Event()

        def on_feedback(message: bytes) -> None:
            heard.set()
            feedback = in_release(self._types, f"{self._type}_Feedback", msgspec.json.decode(message))
            values = {"goal_id": {"uuid": uuid}, "feedback": feedback}
            self._feedback.publish(self._types.encode(f"{self._type}_FeedbackMessage", values))

        sent = await self._parts.link.send_goal(self._name, self._type, goal, on_feedback)
        sent.end.add_done_callback(lambda _: heard.set())
        with contextlib.suppress(TimeoutError):  # neither feedback nor a refusal: the goal was accepted
            await asyncio.wait_for(heard.wait(), REFUSAL_WAIT)
        if sent.end.done() and not sent.end.result().status:
            self._parts.notices.warn(f"the cloud refused a goal of {self._name!r}: {sent.end.result().reason}")
            return False
        self._goals[uuid] = _Goal(uuid, stamp, sent, heard, asyncio.get_running_loop().create_future())
        self._forget()
        self._publish_status()
        self._parts.start(self._finish(self._goals[uuid]))
        return True

    async def _finish(self, goal: _Goal) -> None:
        end = await goal.sent.end
        goal.status = end.status or ABORTED
        result = result_of(self._type, self._types, msgspec.json.decode(end.result), end.reason)
        goal.done.set_result({"status": goal.status, "result": result})
        self._publish_status()

    async def _get_result(self, request: bytes) -> bytes:
        kind = f"{self._type}_GetResult"
        goal = self._goals.get(self._types.decode(f"{kind}_Request", request)["goal_id"]["uuid"])
        values = await asyncio.shield(goal.done) if goal is not None else {"status": 0}
        return self._types.encode(f"{kind}_Response", values)

    async def _cancel_goal(self, request: bytes) -> bytes:
        wanted = self._types.decode(f"{CANCEL}_Request", request)["goal_info"]
        uuid, stamp = wanted["goal_id"]["uuid"], (wanted["stamp"]["sec"], wanted["stamp"]["nanosec"])
        named = any(uuid)
        goals = [
            goal
            for goal in self._goals.values()
            if goal.uuid == uuid
            or (any(stamp) and (goal.stamp["sec"], goal.stamp["nanosec"]) <= stamp)
            or not (named or any(stamp))
        ]
        active = [goal for goal in goals if not goal.done.done()]
        for goal in active:
            goal.status = CANCELING
            await self._parts.link.cancel_goal(goal.sent)
        self._publish_status()
        code = 0 if active or not named else TERMINATED if uuid in self._goals else UNKNOWN_GOAL
        answer = {"return_code": code, "goals_canceling": [goal.info for goal in active]}
        return self._types.encode(f"{CANCEL}_Response", answer)

    # -- state ---------------------------------------------------------------------------------------------------------

    def _publish_status(self) -> None:
        statuses = [{"goal_info": goal.info, "status": goal.status} for goal in self._goals.values()]
        self._status.publish(self._types.encode(GOAL_STATUSES, {"status_list": statuses}))

    def _forget(self) -> None:
        ended = [goal.uuid for goal in self._goals.values() if goal.done.done()]
        for uuid in ended[:-KEPT]:
            del self._goals[uuid]
