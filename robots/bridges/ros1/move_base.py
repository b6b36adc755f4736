"""Navigation as ROS 1 has it: its names, action ``move_base`` by five topics, goals of ``move_base_simple/goal``.

Goals are driven to by the clone, as goals of its action ``navigate_to_pose``. A goal preempts the one before.

Source: http://wiki.ros.org/actionlib/DetailedDescription, ``actionlib_msgs/GoalStatus``.

Source: http://wiki.ros.org/move_base, http://wiki.ros.org/amcl, http://wiki.ros.org/map_server.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any, Final

import msgspec

from ppaas.errors import InvalidInput
from ppaas.messages.actionlib_msgs import Status
from ppaas.wire.ros.graph import LATCHED, Qos
from ppaas.wire.ros.types import to_json
from robots.bridges.core.actions import NAVIGATE
from robots.bridges.core.cloud_link import CloudGoal
from robots.bridges.core.parts import BridgeParts
from robots.bridges.core.tables import MAP, MAP_METADATA, MAP_UPDATES, RELIABLE, UP, BridgedService, DownTopic, Tables
from robots.bridges.core.transport import Closable

ENDS = {4: Status.SUCCEEDED, 5: Status.PREEMPTED, 6: Status.ABORTED}
"""Statuses by the cloud's, which are ROS 2's."""

STATUS_PERIOD = 0.2
"""Time between two messages of ``status`` [s], as of actionlib."""

KEPT = 5.0
"""Time for which an ended goal is in ``status`` [s], as of actionlib."""

MAX_GOALS = 100
"""Largest number of goals in ``status``, and of cancels that came before their goals."""

GOAL_TYPE, POSE = "move_base_msgs/msg/MoveBaseActionGoal", "geometry_msgs/msg/PoseStamped"
STATUS, GOAL_ID = "actionlib_msgs/msg/GoalStatusArray", "actionlib_msgs/msg/GoalID"
FEEDBACK, RESULT = "move_base_msgs/msg/MoveBaseActionFeedback", "move_base_msgs/msg/MoveBaseActionResult"

Stamp = tuple[int, int]


@dataclass(slots=True)
class _Goal:
    id: dict[str, Any]
    status: Status = Status.PENDING
    text: str = ""
    sent: CloudGoal | None = None
    ended: float | None = None
    cancelled: bool = False

    @property
    def report(self) -> dict[str, Any]:
        return {"goal_id": self.id, "status": self.status, "text": self.text}

    @property
    def stamp(self) -> Stamp:
        return _stamp(self.id["stamp"])


class MoveBaseAction:
    """Server of the action.

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
        del name, type_name  # the goals go to another action, and the topics have separate types
        transport, self._parts = parts.transport, parts
        self._goals: dict[str, _Goal] = {}
        self._recalled: deque[str] = deque(maxlen=MAX_GOALS)
        self._cancelled_until: Stamp = (0, 0)
        self._numbers = count(1)
        self._status = transport.publisher(f"{full}/status", STATUS, Qos(depth=1))
        self._feedback = transport.publisher(f"{full}/feedback", FEEDBACK, Qos())
        self._result = transport.publisher(f"{full}/result", RESULT, Qos(depth=MAX_GOALS))
        self._parts_of_action: list[Closable] = [
            self._status,
            self._feedback,
            self._result,
            transport.subscribe(f"{full}/goal", GOAL_TYPE, Qos(), self._reader(GOAL_TYPE, self._take)),
            transport.subscribe(f"{full}/cancel", GOAL_ID, Qos(), self._reader(GOAL_ID, self._cancel)),
            transport.subscribe(f"{full}_simple/goal", POSE, Qos(), self._reader(POSE, self._take_simple)),
        ]
        self._reporting = asyncio.create_task(self._report())

    def close(self) -> None:
        """Withdraw the action."""
        self._reporting.cancel()
        for part in self._parts_of_action:
            part.close()

    def _reader(self, kind: str, take: Callable[[dict[str, Any]], None]) -> Callable[[bytes], None]:
        def received(data: bytes) -> None:
            try:
                take(self._parts.transport.types.decode(kind, data))
            except InvalidInput as error:
                self._parts.notices.warn(f"a message of Move Base cannot be read: {error}")

        return received

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _take_simple(self, pose: dict[str, Any]) -> None:
        self._take({"goal_id": {"id": "", "stamp": {"sec": 0, "nanosec": 0}}, "goal": {"target_pose": pose}})

    def _take(self, message: dict[str, Any]) -> None:
        given = message["goal_id"]
        stamp = given["stamp"] if any(given["stamp"].values()) else self._parts.time.now()
        name = given["id"] or f"{stamp['sec']}.{stamp['nanosec']:09d}-{next(self._numbers)}"
        if name in self._goals:
            return
        goal = _Goal({"id": name, "stamp": stamp})
        if len(self._goals) >= MAX_GOALS:
            self._end(goal, Status.REJECTED, f"there are {MAX_GOALS} goals already")
            return
        self._goals[name] = goal
        if name in self._recalled or _stamp(stamp) <= self._cancelled_until:
            self._end(goal, Status.RECALLED, "cancelled before it arrived")
        else:
            self._parts.start(self._drive(goal, to_json({"pose": message["goal"]["target_pose"]})))
            self._publish_status()

    async def _drive(self, goal: _Goal, pose: bytes) -> None:
        goal.sent = await self._parts.link.send_goal(
            "navigate_to_pose", NAVIGATE, pose, lambda message: self._progress(goal, message)
        )
        if goal.cancelled:
            await self._parts.link.cancel_goal(goal.sent)
        end = await goal.sent.end
        refused = Status.REJECTED if goal.status is Status.PENDING else Status.ABORTED
        reason = end.reason or str(msgspec.json.decode(end.result).get("error_msg", ""))
        self._end(goal, ENDS.get(end.status, refused), reason)

    def _progress(self, goal: _Goal, message: bytes) -> None:
        """Take feedback of the clone: the first says that the goal was accepted."""
        if goal.status is Status.PENDING:
            goal.status = Status.PREEMPTING if goal.cancelled else Status.ACTIVE
            self._publish_status()
        values = {"base_position": msgspec.json.decode(message).get("current_pose")}
        self._publish(self._feedback, FEEDBACK, {"status": goal.report, "feedback": values})

    def _cancel(self, message: dict[str, Any]) -> None:
        name, stamp = message["id"], _stamp(message["stamp"])
        everything = not name and not any(stamp)
        for goal in list(self._goals.values()):
            if everything or goal.id["id"] == name or (any(stamp) and goal.stamp <= stamp):
                self._cancel_goal(goal)
        if name and name not in self._goals:
            self._recalled.append(name)
        self._cancelled_until = max(self._cancelled_until, stamp)
        self._publish_status()

    def _cancel_goal(self, goal: _Goal) -> None:
        if goal.ended is not None or goal.cancelled:
            return
        goal.cancelled = True
        if goal.status is Status.ACTIVE:
            goal.status = Status.PREEMPTING
        if goal.sent is not None:
            self._parts.start(self._parts.link.cancel_goal(goal.sent))

    def _end(self, goal: _Goal, status: Status, text: str) -> None:
        goal.status, goal.text, goal.ended = status, text, self._parts.clock()
        self._publish(self._result, RESULT, {"status": goal.report, "result": {}})
        self._publish_status()

    # -- status --------------------------------------------------------------------------------------------------------

    async def _report(self) -> None:
        while True:
            self._forget()
            self._publish_status()
            await asyncio.sleep(STATUS_PERIOD)

    def _forget(self) -> None:
        now = self._parts.clock()
        for name in [name for name, goal in self._goals.items() if goal.ended is not None and now - goal.ended > KEPT]:
            del self._goals[name]

    def _publish_status(self) -> None:
        reports = [goal.report for goal in self._goals.values()]
        self._publish(self._status, STATUS, {"status_list": reports})

    def _publish(self, publisher: Any, kind: str, values: dict[str, Any]) -> None:
        header = {"stamp": self._parts.time.now()}
        publisher.publish(self._parts.transport.types.encode(kind, values | {"header": header}))


def _stamp(values: dict[str, int]) -> Stamp:
    return values["sec"], values["nanosec"]


# -- names in ROS 1 of what the bridge carries -------------------------------------------------------------------------

MOVE_BASE: Final = "move_base"

_ROS_2_ONLY = {"goal_pose", "speed_limit", "detections"}
_GRID, _PATH, _POSE = "nav_msgs/msg/OccupancyGrid", "nav_msgs/msg/Path", "geometry_msgs/msg/PoseWithCovarianceStamped"
_EMPTY = "std_srvs/srv/Empty"


def _down(name: str, kind: str, cloud: str = "", *, latched: bool = False) -> DownTopic:
    return DownTopic(cloud or name, kind, name, kind, LATCHED if latched else RELIABLE)


ROS_1: Final = Tables(
    # Goals of `move_base_simple/goal` are taken by the action, as Move Base of ROS 1 does.
    up=tuple(topic for topic in UP if topic.cloud not in _ROS_2_ONLY),
    down=(
        MAP,
        MAP_METADATA,
        MAP_UPDATES,
        _down(f"{MOVE_BASE}/NavfnROS/plan", _PATH, "plan"),
        _down(f"{MOVE_BASE}/DWAPlannerROS/local_plan", _PATH, "local_plan"),
        _down("amcl_pose", _POSE, latched=True),
        _down("particlecloud", "geometry_msgs/msg/PoseArray"),
        _down(f"{MOVE_BASE}/current_goal", "geometry_msgs/msg/PoseStamped"),
        _down(f"{MOVE_BASE}/global_costmap/costmap", _GRID, latched=True),
        _down(f"{MOVE_BASE}/local_costmap/costmap", _GRID, latched=True),
        _down(f"{MOVE_BASE}/local_costmap/footprint", "geometry_msgs/msg/PolygonStamped", latched=True),
        _down("octomap_binary", "octomap_msgs/msg/Octomap", latched=True),
        _down("octomap_full", "octomap_msgs/msg/Octomap", latched=True),
        _down("projected_map", _GRID, latched=True),
    ),
    services=tuple(
        BridgedService(name, kind, name, kind)
        for name, kind in (
            ("static_map", "nav_msgs/srv/GetMap"),
            ("global_localization", _EMPTY),
            ("request_nomotion_update", _EMPTY),
            (f"{MOVE_BASE}/clear_costmaps", _EMPTY),
            (f"{MOVE_BASE}/make_plan", "nav_msgs/srv/GetPlan"),
        )
    ),
    actions={MOVE_BASE: "move_base_msgs/msg/MoveBaseAction"},
)
