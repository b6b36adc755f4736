"""Acknowledged alerts: who has seen to one, and when.

Each is an entry of a log beside the checkpoints of the clones of the user whom the alert concerns. So all kinds of
stores have them, and two endpoints that add different ones at the same time lose none.
"""

import hashlib
from collections.abc import Iterable

import msgspec

from storage.encoding import decode_readable, encode
from storage.ports import CloneStore
from storage.records import CloneCheckpoint, CloneLogChange

ALERTS_RECORD = f"alerts-{hashlib.blake2b(b'alerts', digest_size=16).hexdigest()}"
"""Name among the clones of a user; a robot of this name is unlikely."""

CLOUD = f"cloud-{hashlib.blake2b(b'cloud', digest_size=16).hexdigest()}"
"""Name in place of a user, for alerts of the cloud itself."""

KEPT = 30 * 86_400.0
"""Time for which an acknowledgement is kept [s]."""

MOST = 1000
"""Largest number of acknowledgements of a user; the oldest are dropped first."""

_LOG = "acknowledged"


class Acknowledgement(msgspec.Struct, frozen=True, kw_only=True):
    """An alert that was acknowledged.

    Parameters
    ----------
    object : str
        What it is about, as ``robots/tb1``.
    alert : str
        Which alert of the object.
    by : str
        User who acknowledged it.
    time : float
        Time at which it was acknowledged [s since the epoch]: what began before is acknowledged.
    """

    object: str
    alert: str
    by: str
    time: float

    @property
    def number(self) -> int:
        """Number of the entry, which the same alert of the same object has."""
        name = f"{self.object}\0{self.alert}".encode()
        return int.from_bytes(hashlib.blake2b(name, digest_size=8).digest()) >> 1  # fits in 63 bits


def acknowledgements(store: CloneStore, owner: str) -> list[Acknowledgement]:
    """Return the acknowledged alerts that concern a user, or `CLOUD`, without damaged ones; may block."""
    entries = store.clone_log(owner, ALERTS_RECORD, _LOG)
    placed = ((data, f"clone_logs/{owner}/{ALERTS_RECORD}/{_LOG}/{number}") for number, data in entries)
    return decode_readable(placed, Acknowledgement, None)


def acknowledge(store: CloneStore, owner: str, new: Acknowledgement) -> None:
    """Add an acknowledgement that concerns a user, or `CLOUD`, in place of an earlier one of the alert; may block."""
    others = [one for one in acknowledgements(store, owner) if one.number != new.number]
    change = CloneLogChange(_LOG, {new.number: encode(new)}, [one.number for one in _obsolete(others, new.time)])
    store.save_clone(CloneCheckpoint(owner, ALERTS_RECORD, {}, new.time), change)


def _obsolete(known: Iterable[Acknowledgement], now: float) -> list[Acknowledgement]:
    newest = sorted(known, key=lambda one: one.time, reverse=True)
    return [one for place, one in enumerate(newest) if place >= MOST - 1 or one.time < now - KEPT]
