"""Zones of an AGV, led by its master control: one set of zones is sent, enabled, and those before it are deleted.

Each state of the AGV is compared with the set that is wanted, so a bridge that restarts and messages that are lost end
in the same place. The id of a set is made from its zones: the same zones are never sent twice.
"""

import math
import re
from collections.abc import Sequence
from hashlib import blake2b

import msgspec

from ppaas.wire.vda5050.master.instructions import (
    Complaint,
    Instruction,
    SendActions,
    SendZones,
    errors_in_words,
    instant_action,
)
from ppaas.wire.vda5050.master.settings import TRIES
from ppaas.wire.vda5050.states import State
from ppaas.wire.vda5050.zones import Zone, Zones, ZoneSet

PATIENCE = 10.0
"""Time in which an AGV must carry out an order; then it is sent again, `TRIES` times in all [s]."""

_OWN = re.compile(r"zones-[0-9a-f]{16}")

Step = tuple[str, str]
"""Next action of the AGV, in words, and the id of the set."""


def zone_set_of(map_id: str, zones: Sequence[Zone]) -> Zones:
    """Return the set of zones of a map, with the id that this map and these zones have."""
    key = blake2b(msgspec.json.encode([map_id, zones]), digest_size=8).hexdigest()
    return Zones(map_id=map_id, zone_set_id=f"zones-{key}", zones=list(zones))


class ZoneControl:
    """Leads the zones of one AGV."""

    def __init__(self) -> None:
        self._wanted: Zones | None = None
        self._step: Step = ("", "")
        self._tries, self._sent_at = 0, -math.inf

    def want(self, zones: Zones) -> None:
        """Take the set that the AGV is to use; one without zones ends the use of those before."""
        self._wanted = zones

    def begin_again(self) -> None:
        """Send the AGV again what it has not done: its connection is back."""
        self._step = ("", "")

    def advance(self, state: State, now: float) -> list[Instruction]:
        """Return what to send the AGV in its state [s]."""
        wanted = self._wanted
        if wanted is None:
            return []
        own = [one for one in state.zone_sets or () if _OWN.fullmatch(one.zone_set_id)]
        present = next((one for one in own if one.zone_set_id == wanted.zone_set_id), None)
        if present is None:
            needed = bool(wanted.zones or own)
            return self._tell(("take", wanted.zone_set_id), state, now) if needed else []
        if present.zone_set_status != "ENABLED":
            return self._tell(("enable", wanted.zone_set_id), state, now)
        old = next((one for one in own if one is not present), None)
        return self._tell(("delete", old.zone_set_id), state, now) if old else []

    def _tell(self, step: Step, state: State, now: float) -> list[Instruction]:
        if step != self._step:
            self._step, self._tries, self._sent_at = step, 0, -math.inf
        if now - self._sent_at < PATIENCE or self._tries > TRIES:
            return []
        self._tries += 1
        self._sent_at = now
        verb, zone_set_id = step
        if self._tries > TRIES:
            errors = errors_in_words(state)
            text = f"it does not {verb} zone set {zone_set_id!r}, told {TRIES} times{': ' if errors else ''}{errors}"
            return [Complaint(text)]
        if verb == "take":
            assert self._wanted is not None
            return [SendZones(ZoneSet(zone_set=self._wanted))]
        return [SendActions(instant_action(f"{verb}ZoneSet", now, {"zoneSetId": zone_set_id}))]
