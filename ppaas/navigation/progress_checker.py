"""Progress checker: compares the velocities sent to the base with the motion measured by odometry."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle

WINDOW = 2.0
"""Length of a comparison window [s]; the delay of the network is a small part of it."""

HOLD = 2.0
"""Time for which a base that does not follow commands stands before it is tried again [s]."""

LEAST = 0.2
"""Smallest part of the commanded motion that the base must make."""

FAR, TURN = 0.1, 0.5
"""Commanded motion in a window below which it is not significant [m, rad]."""

GAP, JUMP = 0.5, 1.0
"""Longest gap [s] and largest jump of odometry [m] across which motions are compared."""

FORGOTTEN = 10.0
"""Time without a significant window after which a failure is forgotten [s]."""


@dataclass(frozen=True, slots=True)
class ProgressFailure:
    """A base that does not follow commands.

    Parameters
    ----------
    since : float
        Start of the first window in which it did not [s].
    reason : str
        Text for the status of the goal.
    """

    since: float
    reason: str


class _Window:
    """Sums of commanded and measured motion in a window [m, rad]; motions back and forth cancel out."""

    def __init__(self, began: float) -> None:
        self.began = began
        self._seconds = 0.0
        self._commanded, self._measured = Velocity(), Velocity()

    def add(self, seconds: float, sent: Velocity, step: Pose2D) -> None:
        commanded, measured = self._commanded, self._measured
        self._seconds += seconds
        self._commanded = Velocity(commanded.linear + sent.linear * seconds, commanded.angular + sent.angular * seconds)
        self._measured = Velocity(measured.linear + step.x, measured.angular + wrap_angle(step.theta))

    @property
    def significant(self) -> bool:
        return abs(self._commanded.linear) >= FAR or abs(self._commanded.angular) >= TURN

    def failure(self) -> str:
        """Return the reason for which the base does not follow commands; empty if it follows them."""
        for commanded, measured, least, unit in (
            (self._commanded.linear, self._measured.linear, FAR, "m/s"),
            (self._commanded.angular, self._measured.angular, TURN, "rad/s"),
        ):
            if abs(commanded) >= least and measured / commanded < LEAST:
                sent, driven = commanded / self._seconds, measured / self._seconds
                return f"the base does not follow cmd_vel: {sent:.2f} {unit} commanded, {driven:.2f} {unit} driven"
        return ""


class ProgressChecker:
    """Compares commanded and measured motion, window by window.

    If they differ, the robot must stand for `HOLD`; then it is tried again for a window.
    """

    def __init__(self) -> None:
        self._last: tuple[float, Pose2D] | None = None
        self._window = _Window(0.0)
        self._failure: ProgressFailure | None = None
        self._held_until = self._judged_at = float("-inf")

    def look(self, now: float, sent: Velocity, odom: Pose2D) -> ProgressFailure | None:
        """Add a control cycle; return the failure because of which the robot must stand now, or None.

        Parameters
        ----------
        now : float
            Current time [s].
        sent : Velocity
            Velocity sent since the last call.
        odom : Pose2D
            Pose of the robot in the odometry frame.
        """
        last, self._last = self._last, (now, odom)
        if now < self._held_until:
            self._window = _Window(now)
            return self._failure
        if last is None or now - last[0] > GAP or odom.distance_to(last[1]) > JUMP:
            self._window = _Window(now)
            return None
        self._window.add(now - last[0], sent, last[1].inverse() @ odom)
        if now - self._window.began < WINDOW:
            return None
        self._judge(now)
        return self._failure if now < self._held_until else None

    def _judge(self, now: float) -> None:
        window, self._window = self._window, _Window(now)
        if not window.significant:
            if now - self._judged_at > FORGOTTEN:
                self._failure = None
            return
        self._judged_at = now
        reason = window.failure()
        if not reason:
            self._failure = None
            return
        since = window.began if self._failure is None else self._failure.since
        self._failure, self._held_until = ProgressFailure(since, reason), now + HOLD
