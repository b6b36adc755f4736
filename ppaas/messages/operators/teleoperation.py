"""Messages of ``ppaas_msgs`` by which an operator drives a robot by hand."""

from enum import StrEnum

from ppaas.messages.base.message import OwnMessage, UInt32
from ppaas.messages.base.std_msgs import Header

PACKAGE = "ppaas_msgs"
"""ROS package of the types here."""


class DriverRequest(StrEnum):
    """What a driver requests beside the velocity."""

    NOTHING = ""
    DRIVE = "drive"
    TAKE_OVER = "take over"
    LEAVE = "leave"
    GIVE_BACK = "give back"


class TeleopMode(StrEnum):
    """What a robot does for its driver."""

    FREE = "free"
    READY = "ready"
    DRIVING = "driving"
    SLOWED = "slowed"
    BLOCKED = "blocked"
    LOCKED = "locked"
    REFUSED = "refused"


class TeleopCommand(OwnMessage):
    """``ppaas_msgs/TeleopCommand``: what the driver of a robot wants now.

    Parameters
    ----------
    id : str
        Name that the driver's program made up for itself, such as a random text.
    number : int
        Number of the command; each is larger than the one before.
    linear, angular : float
        Velocity: forward [m/s], and turning to the left [rad/s].
    enable : bool
        Whether the driver holds the dead-man's control.
    echo : int
        ``number`` of the last ``TeleopState`` that has come.
    held : float
        Time since it came [s].
    view : int
        ``number`` of the last ``TeleopState`` that came before the pose that the driver sees.
    request : str
        ``drive`` to become the driver if nobody drives, ``take over`` to become it in place of another, ``leave`` to
        drive no longer, ``give back`` to drive no longer and have the robot go on to its goal; empty for none of these.
    driver : str
        User who drives. The cloud sets it.
    """

    id: str
    number: UInt32
    linear: float = 0.0
    angular: float = 0.0
    enable: bool = False
    echo: UInt32 = 0
    held: float = 0.0
    view: UInt32 = 0
    request: str = DriverRequest.NOTHING
    driver: str = ""


class TeleopState(OwnMessage):
    """``ppaas_msgs/TeleopState``: who drives a robot by hand, and what the robot does.

    Parameters
    ----------
    number : int
        Number of the state, for ``echo`` and ``view`` of commands.
    id, driver : str
        Id and user of the driver; empty while nobody drives.
    mode : str
        ``free``: nobody drives; ``ready``: the driver wants no motion; ``driving``; ``slowed``: slower than wanted;
        ``blocked``: something is in the way; ``locked``: the driver has to let go of the control first; ``refused``:
        this robot is not driven by hand.
    text : str
        Reason, in words.
    command : int
        Number of the last command of the driver that was taken.
    linear, angular : float
        Velocity that was sent to the base [m/s, rad/s].
    max_linear, max_angular : float
        Fastest speeds [m/s, rad/s].
    command_timeout, view_timeout : float
        Ages of commands, and of what the driver sees, above which the robot stops [s].
    """

    header: Header
    number: UInt32
    id: str = ""
    driver: str = ""
    mode: str = TeleopMode.FREE
    text: str = ""
    command: UInt32 = 0
    linear: float = 0.0
    angular: float = 0.0
    max_linear: float = 0.0
    max_angular: float = 0.0
    command_timeout: float = 0.0
    view_timeout: float = 0.0
