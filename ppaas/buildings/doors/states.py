"""Reports of doors, and the orders of their controller; ``Wait`` and ``Refuse`` are as for lifts."""

from typing import Literal, get_args

import msgspec

from ppaas.buildings.lifts.states import Refuse, Wait

DoorMode = Literal["closed", "moving", "open", "offline", "unknown"]
"""Modes of ``rmf_door_msgs``, in the order of their numbers."""

DOOR_MODES: tuple[DoorMode, ...] = get_args(DoorMode)


class DoorState(msgspec.Struct, frozen=True, kw_only=True):
    """What a door reports.

    Parameters
    ----------
    floor, door : str
        Floor, and name of the door there.
    mode : {"closed", "moving", "open", "offline", "unknown"}
    """

    floor: str
    door: str
    mode: DoorMode = "closed"


class DoorRequest(msgspec.Struct, frozen=True):
    """The door opens and stays open, or is free to close; the request to open is repeated.

    A door closes by itself if no request has come for 10 s.
    """

    floor: str
    door: str
    session: str
    mode: Literal["open", "closed"]


class Pass(msgspec.Struct, frozen=True):
    """The robot drives through the door, which is open."""

    robot: str
    floor: str
    door: str


class DoorAlert(msgspec.Struct, frozen=True):
    """People must look at a door."""

    floor: str
    door: str
    robot: str
    text: str


DoorOrder = DoorRequest | Pass | Wait | Refuse | DoorAlert
