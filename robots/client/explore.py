"""Client of the action ``explore``: sends a goal, reports its feedback, and waits for its result."""

from collections.abc import Callable
from dataclasses import dataclass

from ppaas.clock import Clock, epoch, monotonic
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.explore_msgs import ExploreFeedback, ExploreGoal, ExploreResult
from ppaas.nodes.nav2_actions import EXPLORE
from robots.client.action_client import ANSWER_TIMEOUT, ActionClient
from robots.client.robot_client import RobotClient

LACKING = (
    "the robot has no node 'explore'; its robot file must name a new map ('map=new:NAME'), and the robot must connect "
    "again after a change"
)


@dataclass(frozen=True, slots=True)
class ExploreOutcome:
    """Outcome of a goal: its status, the node's explanation, and its result if one has come."""

    status: Status
    text: str
    result: ExploreResult


class ExploreClient:
    """Lets one robot explore.

    Parameters
    ----------
    client : RobotClient
        Connected client in the role of an operator.
    on_feedback : callable, optional
        Called with each feedback.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(
        self,
        client: RobotClient,
        on_feedback: Callable[[ExploreFeedback], None] | None = None,
        clock: Clock = monotonic,
        stamp_clock: Clock = epoch,
    ) -> None:
        self._on_feedback = on_feedback
        self._action: ActionClient[ExploreFeedback, ExploreResult] = ActionClient(
            client, EXPLORE, lacking=LACKING, on_feedback=self._take_feedback, clock=clock, stamp_clock=stamp_clock
        )
        self._last = ExploreResult()

    async def explore(self, *, return_to_start: bool = False, answer_timeout: float = ANSWER_TIMEOUT) -> ExploreOutcome:
        """Send a goal and wait for its outcome. If the coroutine is cancelled, so is the goal.

        Parameters
        ----------
        return_to_start : bool
            Whether the robot drives back when no frontier is left.
        answer_timeout : float
            Time within which the node must report the goal [s].

        Raises
        ------
        Unavailable
            The clone of the robot has no node ``explore``, or it does not know the goal any more.
        PPaaSError
            The client has lost its connection for good.
        """
        status, result = await self._action.run(ExploreGoal(return_to_start), answer_timeout)
        return ExploreOutcome(Status(status.status), status.text, result or self._last)

    def _take_feedback(self, now: ExploreFeedback) -> None:
        self._last = ExploreResult(now.frontiers, now.unreachable, now.area, now.distance, now.exploration_time)
        if self._on_feedback is not None:
            self._on_feedback(now)
