"""One run of a behaviour: how far it has come, and its next velocity."""

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.navigation.progress_checker import ProgressChecker
from ppaas.nodes.move_base.behavior_kinds import BehaviorGoal, BehaviorKind
from ppaas.recoveries.base import RecoveryRequest


class BehaviorRun:
    """Progress of a behaviour.

    Parameters
    ----------
    kind : BehaviorKind
    goal : BehaviorGoal
    now : float
        Time at which it begins here [s].
    spent : float
        Time for which it ran in another executor [s].

    Attributes
    ----------
    done : float
        How far it has come [rad, m, s].
    sent : Velocity
        Last velocity sent to the base.
    progress : ProgressChecker
        Watches whether the base follows.
    """

    def __init__(self, kind: BehaviorKind, goal: BehaviorGoal, now: float, spent: float) -> None:
        self.kind = kind
        self.goal = goal
        self.done = 0.0
        self.sent = Velocity()
        self.progress = ProgressChecker()
        self._recovery = kind.recovery(goal)
        self._here = now
        self._began = now - spent
        self._start: Pose2D | None = None
        self._last = Pose2D(0.0, 0.0)
        self._stepped = False

    def spent(self, now: float) -> float:
        """Return how long the behaviour has taken in all [s]."""
        return now - self._began

    def is_late(self, now: float) -> bool:
        """Return whether the time allowance has passed."""
        return self.spent(now) > self.goal.allowance

    def see(self, pose: Pose2D) -> None:
        """Take the pose of the robot."""
        if self._start is None:
            self._start = self._last = pose
        self.done = self.kind.traveled(self.done, self._start, self._last, pose)
        self._last = pose

    def wait(self, now: float) -> bool:
        """Take the time of a behaviour that does not move the robot; return whether it is over."""
        self.done = now - self._here
        return self.done >= self.goal.amount

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return the velocity of this cycle, or None when the goal is reached; raises ``RecoveryFailed``."""
        if self.goal.amount == 0.0:
            return None
        if not self._stepped:
            self._recovery.start(request)
            self._stepped = True
        return self._recovery.step(request)

    def rest(self) -> BehaviorGoal:
        """Return what is left of the goal."""
        return self.kind.rest(self.done, self.goal)
