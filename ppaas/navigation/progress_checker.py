"""Whether a base does what it is told: the velocities that were sent, against the way that its odometry tells."""

from dataclasses import dataclass

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle

WINDOW = 2.0
"""Over which what was asked for and what was done are compared [s]; a link is late by a small part of it."""

HOLD = 2.0
"""A base that did not obey is left standing for so long before it is tried again [s]."""

LEAST = 0.2
"""Part of what was asked for that must be done at least."""

FAR, TURN = 0.1, 0.5
"""Less that is asked for in a window tells nothing [m, rad]."""

GAP, JUMP = 0.5, 1.0
"""Nothing is compared across a longer gap [s], nor where odometry jumped by more [m]."""

FORGOTTEN = 10.0
"""After so long without telling either way what was found is no more of now [s]."""


@dataclass(frozen=True, slots=True)
class Disobedience:
    """That a base does not do what it is told.

    Parameters
    ----------
    since : float
        When that began [s].
    reason : str
    """

    since: float
    reason: str


class _Sums:
    """What was asked for and done in a window, driving and turning [m, rad]: to and fro is nothing of either."""

    def __init__(self, began: float) -> None:
        self.began = began
        self._seconds = 0.0
        self._asked, self._done = Velocity(), Velocity()

    def add(self, seconds: float, sent: Velocity, step: Pose2D) -> None:
        asked, done = self._asked, self._done
        self._seconds += seconds
        self._asked = Velocity(asked.linear + sent.linear * seconds, asked.angular + sent.angular * seconds)
        self._done = Velocity(done.linear + step.x, done.angular + wrap_angle(step.theta))

    @property
    def tell(self) -> bool:
        return abs(self._asked.linear) >= FAR or abs(self._asked.angular) >= TURN

    def complaint(self) -> str:
        for asked, done, least, unit in (
            (self._asked.linear, self._done.linear, FAR, "m/s"),
            (self._asked.angular, self._done.angular, TURN, "rad/s"),
        ):
            if abs(asked) >= least and done / asked < LEAST:
                sent, driven = asked / self._seconds, done / self._seconds
                told = f"{sent:.2f} {unit} were sent, and {driven:.2f} {unit} were driven"
                return f"the base does not do what it is told: {told}"
        return ""


class Obedience:
    """Compares what is sent with what is done, window by window.

    Where they differ the base is to be left standing for a while; then it may be tried again for a window.
    """

    def __init__(self) -> None:
        self._last: tuple[float, Pose2D] | None = None
        self._sums = _Sums(0.0)
        self._found: Disobedience | None = None
        self._held_until = self._told_at = float("-inf")

    def look(self, now: float, sent: Velocity, odom: Pose2D) -> Disobedience | None:
        """Take what was sent since the last look, and where odometry has come; tell why the robot is to stand now.

        Parameters
        ----------
        now : float
            [s].
        sent : Velocity
        odom : Pose2D
            In the odometry frame.
        """
        last, self._last = self._last, (now, odom)
        if now < self._held_until:
            self._sums = _Sums(now)
            return self._found
        if last is None or now - last[0] > GAP or odom.distance_to(last[1]) > JUMP:
            self._sums = _Sums(now)
            return None
        self._sums.add(now - last[0], sent, last[1].inverse() @ odom)
        if now - self._sums.began < WINDOW:
            return None
        self._judge(now)
        return self._found if now < self._held_until else None

    def _judge(self, now: float) -> None:
        sums, self._sums = self._sums, _Sums(now)
        if not sums.tell:
            if now - self._told_at > FORGOTTEN:
                self._found = None
            return
        self._told_at = now
        complaint = sums.complaint()
        if not complaint:
            self._found = None
            return
        since = sums.began if self._found is None else self._found.since
        self._found, self._held_until = Disobedience(since, complaint), now + HOLD
