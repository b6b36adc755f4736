"""Client that sends a robot from goal to goal, and checks how each goal ends: the robot itself, or an operator."""

import asyncio
import itertools
from collections.abc import Callable, Sequence

from benchmarks.chaos.goal_results import GoalResults
from benchmarks.chaos.goal_trace import GoalTrace, Standing
from benchmarks.chaos.silences import Silences
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.nodes.granted_move_base.node import GIVING_WAY
from robots.client.goal_tracker import TrackedGoal
from robots.client.robot_client import RobotClient

PATIENCE = 240.0
"""Time within which a goal must end or be reported lost [s]."""

LOOK = 0.5
"""Period at which a goal without a result is checked [s]."""


class GoalSender:
    """Sends goals to one robot, one after the other.

    Parameters
    ----------
    name : str
        Name of the client, with which its goals begin.
    targets : sequence of Pose2D
        The goals, which the robot visits in a circle.
    expecting : sequence of Silences
        Told when the robot has a goal.
    standing : callable
        Returns the state of the robot.
    tell : callable
        Called with a description of each error.

    Attributes
    ----------
    goals : GoalResults
        The goals, and how they ended.
    """

    def __init__(
        self,
        name: str,
        targets: Sequence[Pose2D],
        expecting: Sequence[Silences],
        standing: Callable[[], Standing],
        tell: Callable[[str], None],
    ) -> None:
        self.goals = GoalResults(name, tell)
        self._name = name
        self._targets = itertools.cycle(targets)
        self._expecting = expecting
        self._standing = standing
        self._numbers = itertools.count(1)
        self._enough = asyncio.Event()
        self._following: TrackedGoal | None = None

    def enough(self) -> None:
        """Stop after the current goal."""
        self._enough.set()

    @property
    def is_over(self) -> bool:
        """True once ``enough`` was called."""
        return self._enough.is_set()

    async def run(self, client: RobotClient) -> None:
        """Send goals by a connected client until ``enough`` is called.

        Raises
        ------
        PPaaSError
            The client has failed for good.
        """
        await client.subscribe("move_base/result", MoveBaseActionResult, self._on_result)
        await client.subscribe("move_base/status", GoalStatusArray, self._on_status)
        while not self.is_over:
            await self._go(client, next(self._targets))

    def _on_status(self, message: GoalStatusArray) -> None:
        if self._following is not None:
            self._following.on_status(message, monotonic())

    def _on_result(self, message: MoveBaseActionResult) -> None:
        if message.status.goal_id.id.startswith(GIVING_WAY):
            return  # the robot's own goal
        self.goals.result(message.status.goal_id.id)
        if self._following is not None:
            self._following.on_result(message)

    async def _go(self, client: RobotClient, target: Pose2D) -> None:
        goal = f"{self._name}-goal-{next(self._numbers)}"
        following = self._following = TrackedGoal(goal)
        self.goals.send(goal)
        for messages in self._expecting:
            messages.goal_sent(monotonic())
        pose = PoseStamped(Header(frame_id="map"), Pose.of(target))
        try:
            session = _session_of(client)
            await client.publish("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(pose), GoalID(id=goal)))
            await self._follow(client, following, session, GoalTrace(target.x, target.y, self._standing))
        except (PPaaSError, asyncio.CancelledError):
            self.goals.end("lost", "the client gave up")
            raise
        finally:
            for messages in self._expecting:
                messages.goal_ended(monotonic())

    async def _follow(self, client: RobotClient, following: TrackedGoal, session: int, trace: GoalTrace) -> None:
        began = now = monotonic()
        while now - began < PATIENCE:
            await asyncio.wait([following.result], timeout=LOOK)
            now = monotonic()
            trace.look(now - began)
            if following.result.done():
                self._ended(client, following, session)
                return
        self.goals.missing(following.goal, PATIENCE, f"{Status(following.status.status).name}, {trace}")

    def _ended(self, client: RobotClient, following: TrackedGoal, session: int) -> None:
        """Count the end of a goal: by its result, by status lists, or because its clone does not know it any more."""
        ended = following.result.result()
        if following.has_result or ended.status != Status.LOST:
            self.goals.end("result" if following.has_result else "status", Status(ended.status).name, ended.text)
            return
        if _session_of(client) == session:
            self.goals.forgotten(following.goal)
        self.goals.end("lost", "unknown to its clone")


def _session_of(client: RobotClient) -> int:
    """Return the number of the session; messages in flight are lost when a new session begins."""
    return client.connections - client.resumptions
