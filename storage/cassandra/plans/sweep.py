"""Sweep of plans in Cassandra: removes unused entries, repairs interrupted writes, and recounts the statistics."""

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ppaas.clock import epoch
from ppaas.plans.encoding.codes import unpack, waypoints_in
from storage.cassandra.connection.session import PAGE
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.representatives import mark_overfull_cells, remove_stale_representatives
from storage.cassandra.plans.rows import delete_plan, head_parts, ids_in, location_cell, rewrite_plan
from storage.cassandra.plans.search import CassandraPlanSearch
from storage.cassandra.plans.statistics import Sums, add
from storage.cassandra.plans.store import own_statistics
from storage.plan_entry import context_of
from storage.records import PlanStatistics

_REPLACED = "SELECT id, lead, head, recipe, WRITETIME(head) AS written FROM plans"
_STORED = "SELECT bucket, spot, id, head, recipe, WRITETIME(head) AS written FROM plans_at_spots"


@dataclass
class _Marked:
    """Entries that plans refer to, and the statistics of the plans.

    Parameters
    ----------
    maps : dict
        Map of each context, by its id.
    sheets : set of bytes
        Ids of the sheets.
    uses : Counter
        Number of plans that refer to each segment, by its id.
    owners : dict
        Map of each segment, by its id.
    sums : dict
        Statistics by map, without plans that were written after the sweep began.
    """

    maps: dict[bytes, str] = field(default_factory=dict)
    sheets: set[bytes] = field(default_factory=set)
    uses: Counter[bytes] = field(default_factory=Counter)
    owners: dict[bytes, str] = field(default_factory=dict)
    sums: Sums = field(default_factory=dict)

    def holds(self, number: bytes) -> bool:
        """Return whether a plan refers to an entry."""
        return number in self.uses or number in self.maps or number in self.sheets

    def add(self, map_id: str, what: PlanStatistics) -> None:
        """Add to the statistics of a map."""
        self.sums[map_id] = add(self.sums.get(map_id, PlanStatistics()), what)


class CassandraSweep(CassandraPlanSearch):
    """Maintenance that no request waits for; ``ppaas store sweep`` runs it."""

    def sweep_entries(self, grace: float = GRACE) -> int:
        """Remove old entries without references; return their number.

        The sweep also completes interrupted replacements, repairs representatives, and recounts the statistics.

        Parameters
        ----------
        grace : float
            Time for which an entry is kept after its last write [s]; longer than writing any plan takes.
        """
        began = epoch()
        sums_before = self._plan_sums.by_writer()
        marked = _Marked()
        # Replacements first, so that the index by ends is complete when its plans are marked.
        for page in self._pages(_REPLACED):
            self._finish_replacing([row for row in page if row.head is not None])
        for page in self._pages(_STORED):
            owned = self._owned(page, epoch() - grace)
            self._mark_page(marked, owned, began * 1e6)
            mark_overfull_cells(self._session, owned)
        swept = self._sweep(marked, began, grace)
        remove_stale_representatives(self._session, began - grace)
        self._plan_sums.recount(marked.sums, sums_before, began)
        uses = "INSERT INTO plan_entry_uses (id, plans) VALUES (?, ?)"
        self._session.write_each(uses, marked.uses.items())
        return swept

    def _pages(self, query: str) -> Iterator[list[Any]]:
        rows = self._session.rows(query)
        while page := list(itertools.islice(rows, PAGE)):
            yield page

    def _finish_replacing(self, replaced: Sequence[Any]) -> None:
        """Copy replaced plans to the index by ends, in case the replacement was interrupted.

        The copies carry the time of the replacement, so later changes of a plan win.
        """
        self._session.write_unlogged((), map(rewrite_plan, replaced))

    def _owned(self, page: Sequence[Any], before: float) -> list[Any]:
        """Return the rows of a page that ``plans`` refers to; delete the others written before a time [s]."""
        named = self._session.rows("SELECT id, lead FROM plans WHERE id IN ?", [row.id for row in page])
        places = {row.id: location_cell(row.lead) for row in named}
        owned: list[Any] = []
        lost: list[Any] = []
        for row in page:
            (owned if places.get(row.id) == (row.bucket, row.spot) else lost).append(row)
        self._session.write_unlogged((), (delete_plan(row) for row in lost if row.written < before * 1e6))
        return owned

    def _mark_page(self, marked: _Marked, page: Sequence[Any], began: float) -> None:
        parts = [head_parts(row.head) for row in page]
        contexts = self._entries.data({context for context, _ in parts} - marked.maps.keys())
        marked.maps.update((number, context_of(data).map) for number, data in contexts.items())
        recipes = self._entries.segment_ids(row.recipe for row in page)
        for row, (context, body), numbers in zip(page, parts, recipes, strict=True):
            ids, on_sheets = ids_in(row.recipe)
            map_id = marked.maps[context]
            marked.sheets.update(ids if on_sheets else ())
            marked.uses.update(set(numbers))
            marked.owners.update(dict.fromkeys(numbers, map_id))
            # Later plans are in the sums of their writers.
            if row.written < began:
                marked.add(map_id, own_statistics(body, row.recipe))

    def _sweep(self, marked: _Marked, began: float, grace: float) -> int:
        """Remove unmarked entries, and add marked segments to the statistics; return the number of removed entries."""
        old = list(self._unmarked(marked, began, (epoch() - grace) * 1e6))
        # Deleted with the time of the last write, so that an entry that is written again meanwhile stays.
        self._session.write_each("DELETE FROM plan_entries USING TIMESTAMP ? WHERE id = ?", old)
        self._session.write_each("DELETE FROM plan_entry_uses WHERE id = ?", [(number,) for _, number in old])
        return len(old)

    def _unmarked(self, marked: _Marked, began: float, before: float) -> Iterator[tuple[int, bytes]]:
        """Yield time of the last write [µs] and id of each entry that can be removed."""
        for row in self._session.rows("SELECT id, data, WRITETIME(data) AS written FROM plan_entries"):
            if row.id in marked.uses and row.written < began * 1e6:
                waypoints = waypoints_in(unpack(row.data))
                marked.add(marked.owners[row.id], PlanStatistics(0, 0, waypoints, 1, len(row.data)))
            elif row.written < before and not marked.holds(row.id):
                yield row.written, row.id
