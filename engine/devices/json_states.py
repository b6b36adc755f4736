"""States and orders of devices as JSON, the same ones over HTTP and MQTT; ``docs/lifts.md`` has their members."""

from typing import Any

import msgspec

from engine.devices.base import DeviceUrl
from ppaas.buildings.building import DoorSettings
from ppaas.buildings.doors.states import DoorMode, DoorRequest, DoorState
from ppaas.buildings.lifts.states import DoorPosition, EndSession, LiftMode, LiftRequest, LiftState, Motion
from ppaas.decoding import from_json
from ppaas.errors import MalformedMessage


class _LiftMembers(msgspec.Struct):
    floor: str
    door: DoorPosition
    motion: Motion = "stopped"
    mode: LiftMode = "agv"
    session: str = ""
    floors: tuple[str, ...] = ()


class _DoorMembers(msgspec.Struct):
    mode: DoorMode


def lift_state_of(body: bytes, lift: str, url: DeviceUrl) -> LiftState:
    """Return the state of a lift, with the names of floors as in the building.

    Raises
    ------
    MalformedMessage
        It is no state; the text says why.
    """
    found = _read(body, _LiftMembers)
    values = msgspec.structs.asdict(found)
    values["floor"] = url.ours(found.floor)
    values["floors"] = tuple(url.ours(floor) for floor in found.floors)
    return LiftState(lift=lift, **values)


def door_state_of(body: bytes, settings: DoorSettings) -> DoorState:
    """Return the state of a door; raise as ``lift_state_of``."""
    return DoorState(floor=settings.floor, door=settings.door, mode=_read(body, _DoorMembers).mode)


def lift_order(order: LiftRequest | EndSession, url: DeviceUrl) -> dict[str, Any]:
    """Return the members of an order to a lift."""
    if isinstance(order, EndSession):
        return {"session": order.session, "end": True}
    return {"session": order.session, "floor": url.theirs(order.floor), "door": order.door}


def door_order(order: DoorRequest) -> dict[str, Any]:
    """Return the members of an order to a door."""
    return {"session": order.session, "mode": order.mode}


def _read(body: bytes, kind: Any) -> Any:
    try:
        return from_json(body, kind)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise MalformedMessage(f"no state of a device: {error!s:.200}") from error
