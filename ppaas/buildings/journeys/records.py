"""Records of journeys, and the orders that a journey gives."""

from typing import Literal

import msgspec

from ppaas.tasks.records import Place

LegKind = Literal["drive", "door", "lift", "way"]

Phase = Literal["planning", "driving", "waiting", "boarding", "inside", "alighting", "looking", "crossing"]
"""``waiting``: before a lift or a door. ``inside``: in the car. ``looking``: out of the car, on a floor that is not yet
known. ``crossing``: on stairs, a ramp or a bridge."""

JourneyState = Literal["active", "succeeded", "failed", "canceled"]


class JourneyLeg(msgspec.Struct, frozen=True, kw_only=True):
    """Part of a journey.

    Parameters
    ----------
    kind : {"drive", "door", "lift", "way"}
    floor, to_floor : str
        Floors on which it begins and ends.
    start, goal : Place
        Poses on the maps of these floors: of a lift, before its door on the one floor and on the other.
    length : float
        Distance that the robot drives [m].
    name : str
        Door, lift or way; empty for a drive.
    """

    kind: LegKind
    floor: str
    to_floor: str
    start: Place
    goal: Place
    length: float = 0.0
    name: str = ""


class Journey(msgspec.Struct, frozen=True, kw_only=True):
    """A journey, as it is stored. Ids of goals follow from it, so that a restart sends none of them twice.

    Parameters
    ----------
    id : str
        Id of the goal that it leads to.
    user, robot, building : str
    floor : str
        Floor of its goal.
    goal : Place
        Its goal on the map of that floor.
    on : str
        Floor on whose map the clone of the robot is.
    legs : tuple of JourneyLeg
        What is planned; empty while it is planned.
    leg : int
        Number of the leg that the robot is on.
    phase : Phase
    sent : int
        Number of goals that were sent, which makes their ids unique.
    failures : int
        Number of goals of this leg that have failed.
    plans : int
        Number of plans.
    place : int
        Its place in the car of the lift.
    out : str
        Floor at which the robot leaves the lift; empty while it does not.
    found : str
        Floor that the robot's scans have shown on this ride; empty while they have not.
    lied : str
        Floor that the lift has named although the scans have shown another one; empty if it has not.
    looks : int
        Number of times that the robot has turned to look round on this ride.
    pressure, pressure_at : float
        Pressure of the air at which it came into the car [Pa], 0 if that is not known, and when [s since the epoch].
    avoid : tuple of str
        Lifts, doors and ways that have refused it.
    cancelled : bool
        Whether it ends once the robot is out of the car.
    state : JourneyState
    text : str
        Why it waits, or why it has ended.
    since : float
        Time at which it began [s since the epoch].
    ended : float, optional
        Time at which it ended; None while it is active.
    """

    id: str
    user: str
    robot: str
    building: str
    floor: str
    goal: Place
    on: str
    legs: tuple[JourneyLeg, ...] = ()
    leg: int = 0
    phase: Phase = "planning"
    sent: int = 0
    failures: int = 0
    plans: int = 0
    place: int = 0
    out: str = ""
    found: str = ""
    lied: str = ""
    looks: int = 0
    pressure: float = 0.0
    pressure_at: float = 0.0
    avoid: tuple[str, ...] = ()
    cancelled: bool = False
    state: JourneyState = "active"
    text: str = ""
    since: float = 0.0
    ended: float | None = None

    @property
    def now(self) -> JourneyLeg:
        """The leg that the robot is on."""
        return self.legs[self.leg]

    @property
    def goal_id(self) -> str:
        """Id of the goal that was sent last."""
        return f"{self.id}/{self.sent}"

    @property
    def looks_for_floor(self) -> bool:
        """Whether it is to be found out on which floor the robot leaves, or has left, the car."""
        return self.state == "active" and self.phase in ("alighting", "looking") and not self.found

    @property
    def is_aboard(self) -> bool:
        """Whether the robot is in the car of a lift, or in its doorway."""
        return self.phase in ("boarding", "inside", "alighting")


# -- orders ------------------------------------------------------------------------------------------------------------


class Keep(msgspec.Struct, frozen=True):
    """Store the journey in place of its former record, before the orders that follow."""

    journey: Journey


class SendGoal(msgspec.Struct, frozen=True):
    """Send the robot to a pose on the map that its clone is on; a goal of a known id is not sent again."""

    id: str
    pose: Place


class CancelGoal(msgspec.Struct, frozen=True):
    """Cancel a goal of the robot."""

    id: str


class FindLegs(msgspec.Struct, frozen=True):
    """Plan from where the robot is, without what is to be avoided; ``Journeys.planned`` or ``no_plan`` answers."""

    number: int


class ChangeFloor(msgspec.Struct, frozen=True):
    """Move the clone of the robot to the map of a floor, on which it has this pose; ``on_floor`` answers."""

    floor: str
    pose: Place


class LookForFloor(msgspec.Struct, frozen=True):
    """Compare the scans of the robot with the maps of all floors at which its lift stops; ``looked`` answers."""


class AskForLift(msgspec.Struct, frozen=True):
    """Request a ride; an order of the lift's controller answers."""

    lift: str
    origin: str
    destination: str


class EnteredCar(msgspec.Struct, frozen=True):
    """Notify the lift's controller that the robot is in the car."""


class LeftCar(msgspec.Struct, frozen=True):
    """Notify the lift's controller that the robot is out of the car."""


class CancelRide(msgspec.Struct, frozen=True):
    """Notify the lift's controller that the robot does not want to ride any more."""


class AskForDoor(msgspec.Struct, frozen=True):
    """Request that a door opens; ``Pass`` of the controller of doors answers."""

    floor: str
    door: str


class DoorPassed(msgspec.Struct, frozen=True):
    """Notify the controller of doors that the robot is clear of a door."""

    floor: str
    door: str


JourneyOrder = (
    Keep
    | SendGoal
    | CancelGoal
    | FindLegs
    | ChangeFloor
    | LookForFloor
    | AskForLift
    | EnteredCar
    | LeftCar
    | CancelRide
    | AskForDoor
    | DoorPassed
)
