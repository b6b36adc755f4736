"""Journeys and rides in a building, as they are stored: one record a building, which the leading master alone writes.

It is stored among the checkpoints of the clones of the building's owner, as the stops of robots are.
"""

import hashlib
from collections.abc import Iterable

import msgspec

from ppaas.buildings.journeys.records import Journey
from ppaas.buildings.lifts.states import LiftRide
from ppaas.errors import NotFound
from storage.encoding import decode, encode
from storage.ports import CloneStore
from storage.records import CloneCheckpoint

_MEMBER = "journeys"


class KeptJourneys(msgspec.Struct):
    """Journeys and rides that have not ended."""

    journeys: tuple[Journey, ...] = ()
    rides: tuple[LiftRide, ...] = ()


def record_name(building: str) -> str:
    """Return the name of the record of a building among its owner's checkpoints, which no robot has."""
    return f"{_MEMBER}-{hashlib.blake2b(building.encode(), digest_size=16).hexdigest()}"


def kept_journeys(store: CloneStore, owner: str, building: str) -> KeptJourneys:
    """Return what is stored of a building; may block."""
    name = record_name(building)
    try:
        record = store.clone(owner, name)
    except NotFound:
        return KeptJourneys()
    return decode(record.nodes[_MEMBER], KeptJourneys, f"clones/{owner}/{name}")


def keep_journeys(
    store: CloneStore, of: tuple[str, str], journeys: Iterable[Journey], rides: Iterable[LiftRide], now: float
) -> None:
    """Store the journeys and rides of a building, by owner and id, at a time [s since the epoch]; may block."""
    owner, building = of
    kept = KeptJourneys(tuple(journeys), tuple(rides))
    if kept.journeys or kept.rides:
        store.save_clone(CloneCheckpoint(owner, record_name(building), {_MEMBER: encode(kept)}, now))
    else:
        store.remove_clone(owner, record_name(building))
