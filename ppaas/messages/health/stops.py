"""Messages of ``ppaas_msgs`` on stops of robots: which robots are stopped, by whom, since when, and why."""

import hashlib
from datetime import UTC, datetime

from msgspec import field

from ppaas.messages.base.message import OwnMessage, ServiceType

PACKAGE = "ppaas_msgs"
"""ROS package of the types here."""

ALL, MAP, ROBOT = "all", "map", "robot"
"""Scopes of stops: all robots of a user, those on a map, one."""


STOPS_RECORD = f"stops-{hashlib.blake2b(b'stops', digest_size=16).hexdigest()}"
"""Name of the record of a user's stops, which is stored among the checkpoints of the user's clones."""


class RobotStop(OwnMessage):
    """``ppaas_msgs/RobotStop``: a stop of robots of one user, which holds until it is released.

    Parameters
    ----------
    scope : str
        ``all``, ``map`` or ``robot``.
    name : str
        Id of the map or the robot; empty for all.
    by : str
        User who stopped them.
    since : float
        Time of the stop [s since the epoch].
    reason : str
        Reason, as the user gave it.
    """

    scope: str
    name: str
    by: str
    since: float
    reason: str = ""

    @property
    def key(self) -> tuple[str, str]:
        """Scope and name: a user's robots have one stop of each."""
        return self.scope, self.name

    def applies_to(self, robot: str, map_id: str) -> bool:
        """Return whether it stops a robot of the user that is on a map."""
        match self.scope:
            case "all":
                return True
            case "map":
                return self.name == map_id
            case _:
                return self.name == robot

    @property
    def in_words(self) -> str:
        """The stop as a text for people."""
        what = {ALL: "all robots are stopped", MAP: f"all robots on map {self.name!r} are stopped"}
        at = datetime.fromtimestamp(self.since, UTC).strftime("%Y-%m-%d %H:%M:%S")
        text = f"{what.get(self.scope, 'stopped')} by {self.by!r} since {at} UTC"
        return f"{text}: {self.reason}" if self.reason else text


class StopState(OwnMessage):
    """``ppaas_msgs/StopState``: whether a robot is stopped, on the topic ``stop/state``.

    Parameters
    ----------
    stopped : bool
        Whether any stop applies.
    stops : list of RobotStop
        Stops that apply.
    text : str
        The stops in words; empty if there is none.
    changed : float
        Time of the last change [s since the epoch].
    """

    stopped: bool = False
    stops: list[RobotStop] = field(default_factory=list)
    text: str = ""
    changed: float = 0.0


class StopRobotRequest(OwnMessage):
    """``ppaas_msgs/StopRobot`` request.

    Parameters
    ----------
    reason : str
        Reason of the stop.
    """

    reason: str = ""


StopRobot = ServiceType("ppaas_msgs/StopRobot", StopRobotRequest, StopState)

SERVICES = (StopRobot,)
