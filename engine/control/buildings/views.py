"""Views of the lifts and doors of a building, as programs read them."""

import msgspec

from ppaas.buildings.doors.states import DoorMode
from ppaas.buildings.lifts.states import DoorPosition, LiftMode, Motion, Phase


class RideView(msgspec.Struct, frozen=True):
    """Robot that rides in a lift or waits for it.

    Parameters
    ----------
    robot, origin, destination : str
    phase : Phase
    since : float
        Time of its request [s since the epoch].
    """

    robot: str
    origin: str
    destination: str
    phase: Phase
    since: float


class LiftView(msgspec.Struct, frozen=True):
    """Lift.

    Parameters
    ----------
    lift : str
    fault : str
        Why it does not serve robots now; empty if it does.
    floor, target : str
        Floor where its car is, and to which it is sent; empty if that is not known, and if it is sent nowhere.
    door, motion, mode, session
        As the lift reported last; its own usual values before the first report.
    rides : list of RideView
        The oldest first.
    """

    lift: str
    fault: str
    floor: str
    target: str
    door: DoorPosition
    motion: Motion
    mode: LiftMode
    session: str
    rides: list[RideView]


class DoorView(msgspec.Struct, frozen=True):
    """Door with a device.

    Parameters
    ----------
    floor, door : str
    mode : DoorMode
        ``unknown`` before the first report.
    robots : list of str
        Robots for which it is held open.
    fault : str
        Why it opens for nobody now; empty if it does.
    """

    floor: str
    door: str
    mode: DoorMode
    robots: list[str]
    fault: str = ""


class BuildingView(msgspec.Struct, frozen=True):
    """State of the lifts and doors of a building that have devices.

    Parameters
    ----------
    lifts : list of LiftView
    doors : list of DoorView
    faults : list of str
        Devices that could not be opened, and why.
    """

    lifts: list[LiftView]
    doors: list[DoorView]
    faults: list[str]
