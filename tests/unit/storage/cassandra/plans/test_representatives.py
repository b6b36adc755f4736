"""The choice of representatives, with a session in memory in place of Cassandra."""

import itertools
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
import pytest

from storage.cassandra.connection.session import MAX_BATCH_BYTES, MAX_BATCH_ROWS, CassandraSession, Write
from storage.cassandra.plans.endpoint_cells import cell_key
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.representatives import OVERFULL, REPRESENTATIVES_PER_CELL, Representatives
from storage.cassandra.plans.rows import UnwrittenPlan, head_parts, insert_names, insert_plans, location_cell, plan_rows
from storage.records import PlanRecord
from tests.support.storage.records import plan


class Session:
    """Records all writes and overfull markers."""

    def __init__(self) -> None:
        self.groups: list[Write] = []
        self.overfull: list[tuple[Any, ...]] = []
        self.is_down = False

    def write_unlogged(self, groups: Iterable[Iterable[Write]], rows: Iterable[Write]) -> None:
        """Record the writes."""
        if self.is_down:
            raise ConnectionError
        self.groups += [write for group in groups for write in group]
        self.overfull += [tuple(values) for _, values in rows]


def representatives(session: Session, now: list[float] | None = None) -> Representatives:
    times = now or [0.0]
    return Representatives(cast(CassandraSession, session), lambda: times[0])


def alike(first: int, last: int) -> list[UnwrittenPlan]:
    return list(plan_rows([plan(f"p{number}") for number in range(first, last)], 8))


def ids(writes: list[Write]) -> list[str]:
    return [values[2] for _, values in writes]


def test_the_first_plan_of_a_cell_represents_it_and_later_ones_mark_it() -> None:
    session = Session()
    chosen = representatives(session)
    assert ids(chosen.choose(alike(0, 1))) == ["p0"]
    assert session.overfull == []
    assert chosen.choose(alike(1, 4)) == []
    [row] = alike(0, 1)
    assert session.overfull == [(*row.cell, OVERFULL, b"")]
    assert chosen.choose(alike(4, 9)) == []
    assert len(session.overfull) == 1, "it is marked once"


def test_other_planners_parameters_and_lengths_have_their_own_cells() -> None:
    session = Session()
    chosen = representatives(session)
    chosen.choose(alike(0, 9))
    others = [plan("jps", planner="jps"), plan("wide", parameters={"robot_radius": 0.5}), plan("long", length=9.0)]
    assert ids(chosen.choose(list(plan_rows(others, 8)))) == ["jps", "wide", "long"]


def test_additional_writes_are_executed_with_and_without_overfull_cells() -> None:
    session = Session()
    chosen = representatives(session)
    chosen.choose(alike(0, 1), [[("name", ("p0",))]])
    chosen.choose(alike(1, 9), [[("name", ("p1",))]])
    assert session.groups == [("name", ("p0",)), ("name", ("p1",))]


def test_a_marker_that_failed_is_written_the_next_time() -> None:
    session = Session()
    chosen = representatives(session)
    session.is_down = True
    with pytest.raises(ConnectionError):
        chosen.choose(alike(0, REPRESENTATIVES_PER_CELL + 1))
    session.is_down = False
    assert chosen.choose(alike(0, REPRESENTATIVES_PER_CELL + 1)) == [], "they may be representatives already"
    assert len(session.overfull) == 1


def test_a_marker_is_rewritten_before_it_may_be_swept() -> None:
    session, now = Session(), [0.0]
    chosen = representatives(session, now)
    chosen.choose(alike(0, 9))
    now[0] = 0.4 * GRACE
    chosen.choose(alike(9, 10))
    assert len(session.overfull) == 1
    now[0] = 0.6 * GRACE
    chosen.choose(alike(10, 11))
    assert len(session.overfull) == 2


def test_a_location_has_the_cell_of_a_plan_and_differs_between_plans() -> None:
    one, other = plan_rows([plan("p"), plan("p", cost=1.0)], 8)
    assert location_cell(one.location) == one.cell == location_cell(other.location)
    assert one.location != other.location
    assert head_parts(one.head) == (one.context, one.entry.body)


def from_place(number: int, metres: float) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, 0] = metres
    return plan(f"p{number}", poses=poses.tobytes())


def test_interleaved_plans_of_one_bucket_are_sent_together() -> None:
    records = [from_place(number, 10.0 * (number % 4)) for number in range(80)]
    groups = list(insert_plans(list(plan_rows(records, 8))))
    leading = [values[0] for group in groups for _, values in group]
    assert len(leading) == 80
    assert len(list(itertools.groupby(leading))) == len({cell_key(record)[0] for record in records}) == 4


@pytest.mark.parametrize("places", [1, 3, 50])
def test_batches_stay_within_the_limits_of_cassandra(places: int) -> None:
    rows = list(plan_rows([from_place(number, 10.0 * (number % places)) for number in range(50)], 8))
    for groups in (list(insert_plans(rows)), list(insert_names(rows))):
        assert all(len({(cql, values[0]) for cql, values in group}) <= MAX_BATCH_ROWS for group in groups)
        sizes = [
            sum(len(value) for _, values in each for value in values if isinstance(value, bytes)) for each in groups
        ]
        assert max(sizes) <= MAX_BATCH_BYTES
    ids = [row.record.id for row in rows]
    assert sorted(values[2] for group in insert_plans(rows) for _, values in group) == sorted(ids)
    assert sorted(values[-1] for group in insert_names(rows) for cql, values in group if "by_map" in cql) == sorted(ids)
    assert [values for group in insert_names(rows) for cql, values in group if "INTO plans " in cql] == [
        (row.record.id, row.location) for row in rows
    ]
