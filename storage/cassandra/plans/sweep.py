"""Sweeping a Cassandra: what no plan refers to any more goes, and what is told of all others is counted anew."""

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ppaas.clock import epoch
from ppaas.plans.encoding.codes import unpack, waypoints_in
from storage.cassandra.connection.session import PAGE
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.representative_sweep import mark_overfull_cells, remove_stale_representatives
from storage.cassandra.plans.rows import head_parts, ids_in, location_cell
from storage.cassandra.plans.search import CassandraPlanSearch
from storage.cassandra.plans.statistics import Sums, add
from storage.cassandra.plans.store import own_statistics
from storage.cassandra.plans.writes import delete_plan, rewrite_plan
from storage.plan_entry import context_of
from storage.records import PlanStatistics

_REPLACED = "SELECT id, lead, head, recipe, WRITETIME(head) AS written FROM plans"
_STORED = "SELECT bucket, spot, id, head, recipe, WRITETIME(head) AS written FROM plans_at_spots"


@dataclass
class _Marked:
    """What plans refer to, and what they take.

    Parameters
    ----------
    maps : dict
        By the ids of contexts their maps.
    sheets : set of bytes
    uses : Counter
        By the ids of stretches how many plans refer to them.
    owners : dict
        By the ids of stretches their maps.
    sums : dict
        By map, without those of plans that were written since this was begun.
    """

    maps: dict[bytes, str] = field(default_factory=dict)
    sheets: set[bytes] = field(default_factory=set)
    uses: Counter[bytes] = field(default_factory=Counter)
    owners: dict[bytes, str] = field(default_factory=dict)
    sums: Sums = field(default_factory=dict)

    def holds(self, number: bytes) -> bool:
        """Tell whether any plan refers to an entry."""
        return number in self.uses or number in self.maps or number in self.sheets

    def add(self, map_id: str, what: PlanStatistics) -> None:
        """Add to what the plans of a map take."""
        self.sums[map_id] = add(self.sums.get(map_id, PlanStatistics()), what)


class CassandraSweep(CassandraPlanSearch):
    """What nobody waits for, and ``ppaas store sweep`` does."""

    def sweep_entries(self, grace: float = GRACE) -> int:
        """Remove the entries that no plan refers to any more and nobody wrote of late; return how many.

        Whatever is counted while plans come and go is counted anew.

        Parameters
        ----------
        grace : float
            How long an entry is kept after it was written last [s]; longer than any plan takes to be kept.
        """
        began = epoch()
        told = self._plan_sums.by_writer()
        marked = _Marked()
        for page in self._pages(_REPLACED):
            self._finish_replacing([row for row in page if row.head is not None])
        for page in self._pages(_STORED):
            owned = self._owned(page, epoch() - grace)
            self._mark_page(marked, owned, began * 1e6)
            mark_overfull_cells(self._session, owned)
        swept = self._sweep(marked, began, grace)
        remove_stale_representatives(self._session, began - grace)
        self._plan_sums.recount(marked.sums, told, began)
        uses = "INSERT INTO plan_entry_uses (id, plans) VALUES (?, ?)"
        self._session.write_each(uses, marked.uses.items())
        return swept

    def _pages(self, query: str) -> Iterator[list[Any]]:
        rows = self._session.rows(query)
        while page := list(itertools.islice(rows, PAGE)):
            yield page

    def _finish_replacing(self, replaced: Sequence[Any]) -> None:
        """Have plans that were replaced lie where they are found: who replaced one may have been cut off before that.

        What is written carries the time of the replacement, so whatever was done to the plan since then stays.
        """
        self._session.write_unlogged((), map(rewrite_plan, replaced))

    def _owned(self, page: Sequence[Any], before: float) -> list[Any]:
        """Return the rows of a page in which plans lie by what names them; of the others the older ones are removed."""
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
            if row.written < began:
                marked.add(map_id, own_statistics(body, row.recipe))

    def _sweep(self, marked: _Marked, began: float, grace: float) -> int:
        """Remove what is not marked, and count the waypoints of what is."""
        old = list(self._unmarked(marked, began, (epoch() - grace) * 1e6))
        # Whoever writes one of them again meanwhile does so later than it was written last: that one stays.
        self._session.write_each("DELETE FROM plan_entries USING TIMESTAMP ? WHERE id = ?", old)
        self._session.write_each("DELETE FROM plan_entry_uses WHERE id = ?", [(number,) for _, number in old])
        return len(old)

    def _unmarked(self, marked: _Marked, began: float, before: float) -> Iterator[tuple[int, bytes]]:
        """Yield when each entry was written that may go, and its id."""
        for row in self._session.rows("SELECT id, data, WRITETIME(data) AS written FROM plan_entries"):
            if row.id in marked.uses and row.written < began * 1e6:
                waypoints = waypoints_in(unpack(row.data))
                marked.add(marked.owners[row.id], PlanStatistics(0, 0, waypoints, 1, len(row.data)))
            elif row.written < before and not marked.holds(row.id):
                yield row.written, row.id
