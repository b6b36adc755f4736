"""Reports of lifts, and the orders of their controller to robots, lifts and the store.

Names are as in ``rmf_lift_msgs`` of Open-RMF, whose states and requests have the same meaning.
"""

from typing import Literal, get_args

import msgspec

DoorPosition = Literal["open", "closed", "moving"]

Motion = Literal["up", "down", "stopped"]

LiftMode = Literal["agv", "human", "fire", "offline", "emergency", "unknown"]
"""Who has a lift: robots (``agv``), people (``human``), fire fighters, nobody (``offline``)."""

Phase = Literal["waiting", "boarding", "inside", "alighting"]
"""Phase of a ride. In ``boarding`` and ``alighting`` the robot may be in the doorway."""

MODES: tuple[LiftMode, ...] = get_args(LiftMode)


class LiftState(msgspec.Struct, frozen=True, kw_only=True):
    """What a lift reports.

    Parameters
    ----------
    lift : str
        Id of the lift.
    floor : str
        Floor at which its car is, or which it passed last; empty if that is not known.
    door : {"open", "closed", "moving"}
        Doors of the car, and of the landing at which it stands.
    motion : {"up", "down", "stopped"}
    mode : LiftMode
    session : str
        Session to which the lift listens; empty if it has none.
    floors : tuple of str
        Floors at which it stops now; empty if it does not report them.
    """

    lift: str
    floor: str = ""
    door: DoorPosition = "closed"
    motion: Motion = "stopped"
    mode: LiftMode = "agv"
    session: str = ""
    floors: tuple[str, ...] = ()


class LiftRide(msgspec.Struct, frozen=True, kw_only=True):
    """LiftRide of a robot in a lift, as it is stored.

    Parameters
    ----------
    robot, lift, origin, destination : str
        The robot, the lift, and the floors between which it rides.
    size : int
        Number of robots of usual size that its place in the car would take.
    since : float
        Time of its request [s since the epoch].
    phase : Phase
    goes : bool
        Whether it leaves the car at the next floor where it can, because it was cancelled.
    place : int
        Its place in the car, from when it boards: see ``ppaas.buildings.riding.car_frame.places_in_car``.
    """

    robot: str
    lift: str
    origin: str
    destination: str
    size: int = 1
    since: float = 0.0
    phase: Phase = "waiting"
    goes: bool = False
    place: int = 0

    @property
    def is_aboard(self) -> bool:
        """Return whether the robot takes room in the car."""
        return self.phase != "waiting"

    @property
    def is_in_doorway(self) -> bool:
        """Return whether the robot may be between the doors."""
        return self.phase in ("boarding", "alighting")


# -- orders to robots --------------------------------------------------------------------------------------------------


class Board(msgspec.Struct, frozen=True):
    """The robot drives to a place in the car, which stands open at the floor."""

    robot: str
    lift: str
    floor: str
    place: int = 0


class Alight(msgspec.Struct, frozen=True):
    """The robot leaves the car, which stands open at the floor; that may be another one than its destination."""

    robot: str
    lift: str
    floor: str


class Wait(msgspec.Struct, frozen=True):
    """The robot stays where it is, and why.

    Parameters
    ----------
    robot, reason : str
    clear : bool
        Whether it makes way for robots that leave the car.
    """

    robot: str
    reason: str
    clear: bool = False


class Refuse(msgspec.Struct, frozen=True):
    """The ride has ended without the lift, and why; the robot takes another way."""

    robot: str
    reason: str


# -- orders to lifts ---------------------------------------------------------------------------------------------------


class LiftRequest(msgspec.Struct, frozen=True):
    """The car drives to a floor and holds its doors open there; repeated while the session lasts.

    A lift ends a session by itself if no request has come for 10 s.
    """

    lift: str
    session: str
    floor: str
    door: Literal["open"] = "open"


class EndSession(msgspec.Struct, frozen=True):
    """The lift is free for others."""

    lift: str
    session: str


# -- orders to the store and to people ---------------------------------------------------------------------------------


class StoreRide(msgspec.Struct, frozen=True):
    """Store a ride in place of the record of the same robot, before the orders that follow."""

    ride: LiftRide


class RemoveRide(msgspec.Struct, frozen=True):
    """Remove the stored ride of a robot: it has ended."""

    robot: str


class LiftAlert(msgspec.Struct, frozen=True):
    """People must look at a lift."""

    lift: str
    robot: str
    text: str


LiftOrder = Board | Alight | Wait | Refuse | LiftRequest | EndSession | StoreRide | RemoveRide | LiftAlert
