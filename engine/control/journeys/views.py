"""Views of a building whose lifts and doors are led: their states, and the journeys in it."""

import msgspec

from engine.control.buildings.views import BuildingView
from ppaas.buildings.journeys.records import JourneyState, Phase


class JourneyView(msgspec.Struct, frozen=True):
    """Robot on a journey, or at the end of one.

    Parameters
    ----------
    id, user, robot : str
    on, floor : str
        Floor where the robot is, and floor of its goal.
    phase : Phase
    leg : str
        Lift, door or way that it takes, or waits for; empty while it drives on a floor.
    state : JourneyState
    text : str
        Why it waits, or why it has ended.
    since : float
        [s since the epoch]
    ended : float, optional
        None while it is active.
    """

    id: str
    user: str
    robot: str
    on: str
    floor: str
    phase: Phase
    leg: str
    state: JourneyState
    text: str
    since: float
    ended: float | None = None


class SiteView(msgspec.Struct, frozen=True):
    """State of a building.

    Parameters
    ----------
    devices : BuildingView
        Its lifts and doors that have devices.
    journeys : list of JourneyView
        The last ones that have ended, then those under way; each the oldest first.
    """

    devices: BuildingView
    journeys: list[JourneyView]


class LiftWait(msgspec.Struct, frozen=True):
    """Wait for a lift at a floor that is expected now [s]; infinite if it does not serve robots."""

    lift: str
    floor: str
    seconds: float
