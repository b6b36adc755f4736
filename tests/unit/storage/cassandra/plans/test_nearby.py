"""The order in which plans near two places are read, with tables in memory in place of Cassandra."""

from collections import namedtuple
from collections.abc import Callable, Iterator
from operator import attrgetter
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans import search
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, cell_key, length_of_cell
from storage.cassandra.plans.representatives import OVERFULL
from storage.cassandra.plans.search import NearbyPlans
from storage.plan_query import PlanStoreQuery
from tests.support.storage.records import plan

Row = namedtuple("Row", ["bucket", "spot", "id", "head"])

SEARCH = PlanStoreQuery("house", "v", (1.0, 1.0), (5.0, 1.0), 0.25)
_key = attrgetter("bucket", "spot", "id")


class Tables:
    """Both tables in memory; each cell has up to two representatives."""

    def __init__(self, plans: list[Row]) -> None:
        self.plans = sorted(plans, key=_key)
        self.representatives: list[Row] = []
        self.queries = 0
        cells: dict[tuple[bytes, int], list[Row]] = {}
        for row in self.plans:
            cells.setdefault((row.bucket, row.spot), []).append(row)
        for cell, rows in cells.items():
            self.representatives += ([Row(*cell, OVERFULL, b"")] if len(rows) > 2 else []) + rows[:2]
        self.representatives.sort(key=_key)

    def rows(self, cql: str, *values: Any) -> Iterator[Row]:
        """Answer queries for representatives."""
        self.queries += 1
        if "IN ?" in cql:
            for bucket in values[0]:
                yield from [row for row in self.representatives if row.bucket == bucket][: values[1]]
        else:
            bucket, spot, plan_id, most = values
            behind = [
                row for row in self.representatives if row.bucket == bucket and (row.spot, row.id) > (spot, plan_id)
            ]
            yield from behind[:most]

    def query_overfull(self, _: str, bucket: bytes, spots: list[int], most: int) -> Callable[[], list[Row]]:
        """Answer queries for plans of overfull cells."""
        self.queries += 1
        return lambda: [row for row in self.plans if row.bucket == bucket and row.spot in spots][:most]


def plan_rows_around(seed: int, count: int) -> list[Row]:
    """Return rows of plans that begin and end around the two places, some too far away, some alike."""
    random = np.random.default_rng(seed)
    rows: list[Row] = []
    while len(rows) < count:
        poses = np.zeros((2, 7))
        poses[:, :2] = np.array((SEARCH.start, SEARCH.goal)) + random.uniform(-0.3, 0.3, (2, 2))
        length = random.uniform(4, 5)
        for _ in range(random.choice([1, 2, 5])):
            record = plan(f"p{len(rows):03}", map="house", version="v", poses=poses.tobytes(), length=length)
            rows.append(Row(*cell_key(record), b""))
    return rows


def near(tables: Tables) -> NearbyPlans:
    session = namedtuple("Session", ["rows", "query_async"])(tables.rows, tables.query_overfull)
    return NearbyPlans(cast(CassandraSession, session), NearbyBuckets(SEARCH))


def connecting(rows: list[Row]) -> list[Row]:
    around = NearbyBuckets(SEARCH)
    return [row for row in rows if row.bucket in around.ids and around.connecting([row])]


@given(st.integers(0, 1000), st.integers(0, 80), st.integers(2, 9), st.integers(2, 9), st.integers(1, 5))
def test_all_plans_are_read_with_any_page_size(seed, count, first, then, at_once) -> None:
    tables = Tables(plan_rows_around(seed, count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "FIRST", first)
        patch.setattr(search, "NEXT", then)
        patch.setattr(search, "OVERFULL_CELLS_AT_ONCE", at_once)
        waiting = near(tables)
        read, rows = set[str](), waiting.first()
        while rows is not None:
            read |= {row.id for row in rows}
            rows = waiting.more(1000, None)
    assert read >= {row.id for row in connecting(tables.plans)}


@given(st.integers(0, 1000), st.integers(0, 200), st.integers(2, 30), st.integers(1, 20))
@example(310, 72, 20, 16)  # some overfull cells have enough plans, and others have shorter ones
def test_once_enough_are_found_only_overfull_cells_have_shorter_ones(seed, count, first, limit) -> None:
    tables = Tables(plan_rows_around(seed, count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "FIRST", first)
        waiting, lengths = near(tables), dict[str, int]()
        rows = waiting.first()
        while rows is not None:
            lengths |= {row.id: length_of_cell(row.spot) for row in connecting(rows)}
            shortest = sorted(lengths.values())[:limit]
            rows = waiting.more(limit, shortest[-1] if len(shortest) == limit else None)
    among_representatives = sorted(
        length_of_cell(row.spot) for row in connecting(tables.representatives) if row.id != OVERFULL
    )[:limit]
    everywhere = sorted(length_of_cell(row.spot) for row in connecting(tables.plans))[:limit]
    assert len(shortest) == len(everywhere)
    assert all(length <= other for length, other in zip(shortest, among_representatives, strict=False))
    if len(among_representatives) < limit:
        assert shortest == everywhere


def test_one_query_is_enough_if_there_are_enough_representatives() -> None:
    tables = Tables(plan_rows_around(1, 400))
    waiting = near(tables)
    lengths = sorted(length_of_cell(row.spot) for row in connecting(waiting.first()))
    assert len(lengths) > 16
    assert waiting.more(16, lengths[15]) is None
    assert tables.queries == 1


def test_the_requested_number_of_plans_of_one_cell_is_read() -> None:
    poses = np.zeros((2, 7))
    poses[:, :2] = SEARCH.start, SEARCH.goal
    same = [Row(*cell_key(plan(f"p{n:02}", map="house", version="v", poses=poses.tobytes())), b"") for n in range(90)]
    waiting = near(Tables(same))
    assert [row.id for row in waiting.first()] == ["p00", "p01"]
    assert [row.id for row in waiting.more(70, None) or ()] == [row.id for row in same[:70]]
    assert waiting.more(70, None) is None
