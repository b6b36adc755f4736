"""Lookup of plans in Cassandra by id: first the cell of each plan, then the row in that cell."""

from collections.abc import Sequence
from dataclasses import dataclass

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans.rows import head_parts, location_cell

_LOCATIONS = "SELECT id, lead, head, recipe FROM plans WHERE id = ?"
_STORED = "SELECT head, recipe FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"


@dataclass(frozen=True, slots=True)
class KeptPlan:
    """A stored plan.

    Parameters
    ----------
    id : str
    location : bytes
        Its cell and a hash of its content (``storage.cassandra.plans.rows``).
    replaced : bool
        Whether it was replaced by ``replace_plan``, and is therefore also stored in ``plans``.
    head, recipe : bytes
        Id of its context with its body, and ids of its segments.
    """

    id: str
    location: bytes
    replaced: bool
    head: bytes
    recipe: bytes

    @property
    def context(self) -> bytes:
        """Id of its context."""
        return head_parts(self.head)[0]

    @property
    def body(self) -> bytes:
        """Data of this plan alone (``ppaas.plans.encoding.body``)."""
        return head_parts(self.head)[1]


def kept_plans(session: CassandraSession, plan_ids: Sequence[str]) -> list[KeptPlan | None]:
    """Return the stored plan of each id; None where it does not exist, or was not written completely."""
    located = session.rows_each(_LOCATIONS, [(plan_id,) for plan_id in plan_ids])
    not_inline = [row for rows in located for row in rows if row.head is None]
    stored = iter(session.rows_each(_STORED, [(*location_cell(row.lead), row.id) for row in not_inline]))
    kept: list[KeptPlan | None] = [None] * len(located)
    for number, rows in enumerate(located):
        for row in rows:
            replaced = row.head is not None
            for whole in rows if replaced else next(stored):
                kept[number] = KeptPlan(row.id, row.lead, replaced, whole.head, whole.recipe)
    return kept
