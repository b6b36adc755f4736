"""Plans in Cassandra by their ids: where each lies, and what lies there."""

from collections.abc import Sequence
from dataclasses import dataclass

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans.rows import head_parts, location_cell

_LOCATIONS = "SELECT id, lead, head, recipe FROM plans WHERE id = ?"
_STORED = "SELECT head, recipe FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"


@dataclass(frozen=True, slots=True)
class KeptPlan:
    """What is kept of a plan under its id.

    Parameters
    ----------
    id : str
    location : bytes
        Where it lies (``cassandra_plan_rows``).
    replaced : bool
        Whether it was replaced, and so lies under its id too.
    head, recipe : bytes
    """

    id: str
    location: bytes
    replaced: bool
    head: bytes
    recipe: bytes

    @property
    def context(self) -> bytes:
        """Return the id of its context."""
        return head_parts(self.head)[0]

    @property
    def body(self) -> bytes:
        """Return what is its own."""
        return head_parts(self.head)[1]


def kept_plans(session: CassandraSession, plan_ids: Sequence[str]) -> list[KeptPlan | None]:
    """Return what is kept of each of some plans; None where there is none, or one that was never wholly written."""
    located = session.rows_each(_LOCATIONS, [(plan_id,) for plan_id in plan_ids])
    not_inline = [row for rows in located for row in rows if row.head is None]
    stored = iter(session.rows_each(_STORED, [(*location_cell(row.lead), row.id) for row in not_inline]))
    kept: list[KeptPlan | None] = [None] * len(located)
    for number, rows in enumerate(located):
        for row in rows:
            replaced = row.head is not None
            for there in rows if replaced else next(stored):
                kept[number] = KeptPlan(row.id, row.lead, replaced, there.head, there.recipe)
    return kept
