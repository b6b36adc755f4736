"""A plan as rows: what is its own, where it is found, and the ids of what it refers to.

A plan refers to what many plans have in common, its *context*, and to the segments that it shares. Both are entries
under a hash of themselves, so whoever keeps one first or again keeps the same.
"""

import hashlib
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from ppaas.errors import Unavailable
from ppaas.plans.encoding.body import PlanBody
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE
from ppaas.plans.encoding.codes import ID_BYTES, entry_id
from storage.cassandra.plans.endpoint_cells import Cell, cell_key
from storage.plan_entry import PlanEntry, entries_of
from storage.records import PlanRecord

MAX_IDS_PER_ROW = 256
"""Ids in a row: a longer recipe is cut into sheets, which are entries of their own, so that no row grows large."""

_IDS, _SHEETS = b"\x00", b"\x01"
_LOCATION = struct.Struct("<16sq8s")

_known_id = lru_cache(1 << 15)(entry_id)
"""Most segments of a plan are those of plans before it."""


@dataclass(frozen=True, slots=True)
class PlanRow:
    """What is kept of a plan.

    Parameters
    ----------
    record : PlanRecord
        As it was given.
    entry : PlanEntry
    context : bytes
        The id of its context.
    recipe : bytes
        The ids of its segments or, of very many, of the sheets that hold these.
    segments : dict
        By their ids the codes of the segments, in their order, each once.
    beside : dict
        By their ids the context and the sheets.
    key : tuple
        Under which it lies (``cassandra_plan_spots.cell_key``).
    """

    record: PlanRecord
    entry: PlanEntry
    context: bytes
    recipe: bytes
    segments: dict[bytes, bytes]
    beside: dict[bytes, bytes]
    key: tuple[bytes, int, str]

    @property
    def size(self) -> int:
        """Return the bytes that are its own."""
        return len(self.entry.body) + len(self.recipe)

    @property
    def cell(self) -> Cell:
        """Return where it lies."""
        return self.key[:2]

    @property
    def head(self) -> bytes:
        """Return the id of its context, and its body (``head_parts``)."""
        return self.context + self.entry.body

    @property
    def location(self) -> bytes:
        """Return where it lies (``location_cell``), and a hash of what lies there."""
        content = hashlib.blake2b(self.head + self.recipe, digest_size=8).digest()
        return _LOCATION.pack(*self.cell, content)


def plan_rows(records: Sequence[PlanRecord], granularity: int) -> Iterator[PlanRow]:
    """Yield the rows of plans.

    Raises
    ------
    InvalidInput
        A plan is not valid (``storage.plan_checks``).
    """
    for record, entry in zip(records, entries_of(records, granularity), strict=True):
        ids = [_known_id(entry.scope, code) for code in entry.codes]
        context = _known_id(entry.scope, entry.context)
        sheets = dict(_sheets(entry.scope, ids))
        recipe = _SHEETS + b"".join(sheets) if sheets else _IDS + b"".join(ids)
        segments = dict(zip(ids, entry.codes, strict=True))
        yield PlanRow(record, entry, context, recipe, segments, {context: entry.context, **sheets}, cell_key(record))


def ids_in(recipe: bytes) -> tuple[list[bytes], bool]:
    """Return the ids in a recipe, and whether they are those of sheets.

    Raises
    ------
    Unavailable
        It is damaged.
    """
    if recipe[:1] not in (_IDS, _SHEETS) or len(recipe) % ID_BYTES != 1:
        raise Unavailable("a stored recipe is damaged: restore it from a backup")
    return ids_on(recipe[1:]), recipe[:1] == _SHEETS


def ids_on(sheet: bytes) -> list[bytes]:
    """Return the ids on a sheet."""
    return [sheet[at : at + ID_BYTES] for at in range(0, len(sheet), ID_BYTES)]


def head_parts(head: bytes) -> tuple[bytes, bytes]:
    """Return the id of the context in a head, and the body."""
    return head[:ID_BYTES], head[ID_BYTES:]


def location_cell(location: bytes) -> Cell:
    """Return where a plan lies."""
    bucket, spot, _ = _LOCATION.unpack(location)
    return bucket, spot


def unshared_in(body: PlanBody) -> int:
    """Return how many waypoints are kept for a plan alone."""
    return ENDS_BEFORE + ENDS_AFTER if body.shared else body.count


def _sheets(scope: bytes, ids: list[bytes]) -> Iterator[tuple[bytes, bytes]]:
    if len(ids) > MAX_IDS_PER_ROW:
        for at in range(0, len(ids), MAX_IDS_PER_ROW):
            sheet = b"".join(ids[at : at + MAX_IDS_PER_ROW])
            yield entry_id(scope, sheet), sheet


def map_key(record: PlanRecord) -> tuple[str, float, str]:
    """Return the key under which a plan is map_key: its map, when it was made, and its id."""
    return record.map, record.created + 0.0, record.id  # -0 would come before 0
