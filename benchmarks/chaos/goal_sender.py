"""Client that sends a robot from goal to goal; each goal must get one result, or its client learns that it is lost."""

import asyncio
import itertools
import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

from benchmarks.chaos.message_checks import Silences
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.nodes.granted_move_base.node import GIVING_WAY
from robots.client.move_base import TrackedGoal
from robots.client.robot_client import RobotClient

Ending = Literal["result", "status", "lost"]


class GoalResults:
    """Goals of one robot, and how they ended.

    Parameters
    ----------
    robot : str
        Name of the robot.
    tell : callable
        Called with a description of each error.
    """

    def __init__(self, robot: str, tell: Callable[[str], None]) -> None:
        self._robot = robot
        self._tell = tell
        self._sent: dict[str, int] = {}
        self.endings: Counter[Ending] = Counter()
        self.statuses: Counter[str] = Counter()
        self.texts: Counter[str] = Counter()

    @property
    def sent(self) -> int:
        """Number of goals sent."""
        return len(self._sent)

    def send(self, goal: str) -> None:
        """Record a goal that was sent."""
        self._sent[goal] = 0

    def result(self, goal: str) -> None:
        """Record a result; a second one for the same goal is an error."""
        if goal not in self._sent:
            self._tell(f"{self._robot} received the result of a goal that it never sent: {goal}")
            return
        self._sent[goal] += 1
        if self._sent[goal] > 1:
            self._tell(f"{self._robot} received {self._sent[goal]} results of {goal}")

    def end(self, ending: Ending, status: str, text: str = "") -> None:
        """Record the end of a goal.

        Parameters
        ----------
        ending : str
            ``result``; ``status`` if the result was lost and the list of statuses shows the end; ``lost`` if a new
            session began whose clone does not know the goal, or if the client gave up.
        status : str
            Final status of the goal.
        text : str
            Reason of a goal that the robot has not reached.
        """
        self.endings[ending] += 1
        self.statuses[status] += 1
        if status != Status.SUCCEEDED.name:
            self.texts[f"{self._robot}: {status}, {text}"] += 1

    def forgotten(self, goal: str) -> None:
        """Record that a clone does not know a goal although no new session began."""
        self._tell(f"{self._robot}: the clone lost {goal} without a new session")

    def missing(self, goal: str, seconds: float, trace: str) -> None:
        """Report a goal that has neither ended nor been lost within a time limit [s], with its trace."""
        self._tell(f"{self._robot}: {goal} did not end within {seconds:.0f} s: {trace}")


# -- trace of a goal ---------------------------------------------------------------------------------------------------

PERIOD = 40.0
"""Time between two entries [s]."""


class Standing(NamedTuple):
    """State of a robot.

    Parameters
    ----------
    x, y : float
        Its position [m].
    lost : float
        Distance between its position and the one that its clone believes in [m].
    simulated : float
        Time of its world [s]; it lags behind if the computer is too slow.
    commands, cycles : int
        Numbers of commands, and of control cycles of its clone, since it was started.
    """

    x: float
    y: float
    lost: float
    simulated: float
    commands: int
    cycles: int

    def __str__(self) -> str:
        """Return where the robot is, and how far from where its clone believes it to be."""
        return f"at {self.x:.2f}, {self.y:.2f}, {self.lost:.2f} m lost"


class GoalTrace:
    """Entries about one goal since it was sent.

    Parameters
    ----------
    x, y : float
        Position of the goal [m].
    standing : callable
        Returns the state of the robot.
    """

    def __init__(self, x: float, y: float, standing: Callable[[], Standing]) -> None:
        self._x, self._y = x, y
        self._standing = standing
        self._last = standing()
        self._entries: list[str] = []

    def look(self, seconds: float) -> None:
        """Add an entry if one is due, ``seconds`` after the goal was sent."""
        if seconds < PERIOD * (len(self._entries) + 1):
            return
        now, last = self._standing(), self._last
        away = math.dist((now.x, now.y), (self._x, self._y))
        self._entries.append(
            f"after {seconds:.0f} s {away:.1f} m away, {now.lost:.1f} m lost, "
            f"{now.simulated - last.simulated:.0f} s simulated, "
            f"{now.commands - last.commands} commands in {now.cycles - last.cycles} cycles"
        )
        self._last = now

    def __str__(self) -> str:
        """Return the entries."""
        return "; ".join(self._entries)


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
