"""The choice of representatives, with a session in memory in place of Cassandra."""

from collections.abc import Iterable
from typing import Any, cast

import pytest

from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.representatives import OVERFULL, REPRESENTATIVES_PER_CELL, Representatives
from storage.cassandra.plans.rows import PlanRow, plan_rows
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


def alike(first: int, last: int) -> list[PlanRow]:
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
