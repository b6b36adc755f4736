"""The path plan database in an SQLite file, for processes that may never need it.

Plans are written and read with compiled kernels, which take a third of a second and 30 MB to load. So the module that
uses them is imported at the first plan: a master has none, and an endpoint only those that programs ask for.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from ppaas.plans.encoding.granularity import GRANULARITY, inner_granularity
from storage.plan_query import PlanStoreQuery
from storage.records import PlanPart, PlanPassage, PlanRecord, PlanStatistics
from storage.sqlite.connections import SqliteConnections

if TYPE_CHECKING:
    from storage.sqlite.plan_tables import PlanTables


class SqlitePlans:
    """A ``PlanStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    granularity : int
        Length from which segments of plans are shared, about [waypoints]; the paper's granularity.

    Raises
    ------
    InvalidInput
        The granularity is out of range.
    """

    def __init__(self, connections: SqliteConnections, granularity: int = GRANULARITY) -> None:
        self._plan_connections = connections
        self._granularity = inner_granularity(granularity)

    @cached_property
    def _tables(self) -> "PlanTables":
        from storage.sqlite.plan_tables import PlanTables  # noqa: PLC0415 - imports numba; see above

        return PlanTables(self._plan_connections, self._granularity)

    def add_plan(self, record: PlanRecord) -> None:
        """Add a plan; adding the same id again changes nothing."""
        self._tables.add_plans((record,))

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Add plans, all or none; return the number of new ones."""
        return self._tables.add_plans(records)

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Replace a plan by one of the same id; ``Conflict`` if the stored plan is not ``instead_of``."""
        self._tables.replace_plan(record, instead_of=instead_of)

    def remove_plan(self, plan_id: str) -> None:
        """Remove a plan; ``NotFound`` if it does not exist."""
        self._tables.remove_plan(plan_id)

    def remove_plans(self, map_id: str) -> int:
        """Remove the plans of a map in several transactions, between which others can write; return their number."""
        return self._tables.remove_plans(map_id)

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan; ``NotFound`` if it does not exist."""
        return self._tables.plan(plan_id)

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return the stored plans among these ids, by id."""
        return self._tables.whole_plans(plan_ids)

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first."""
        return self._tables.plans(map_id, before=before, limit=limit)

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted."""
        return self._tables.plan_maps()

    def find_plans(self, search: PlanStoreQuery, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans that begin and end near two places, shortest first."""
        return self._tables.find_plans(search, limit=limit)

    def plans_through(self, search: PlanStoreQuery, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, shortest passage first."""
        return self._tables.plans_through(search, limit=limit)

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the shared segments of a plan, in order; ``NotFound`` if the plan does not exist."""
        return self._tables.plan_parts(plan_id)

    def plan_faults(self) -> Iterator[str]:
        """Yield the plans that cannot be read, and the segments whose content does not match their hash."""
        return self._tables.plan_faults()

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return the size of the plans of a map, or of all plans."""
        return self._tables.plan_statistics(map_id)
