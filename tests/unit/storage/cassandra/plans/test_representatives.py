"""Which plans are put in front, as no Cassandra is needed to see."""

from collections.abc import Iterable
from typing import Any, cast

import pytest

from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.representatives import OVERFULL, REPRESENTATIVES_PER_CELL, Representatives
from storage.cassandra.plans.rows import PlanRow, plan_rows
from tests.support.storage.records import plan


class Session:
    """Notes what is written beside, each write with its values."""

    def __init__(self) -> None:
        self.groups: list[Write] = []
        self.overfull: list[tuple[Any, ...]] = []
        self.is_away = False

    def write_unlogged(self, groups: Iterable[Iterable[Write]], rows: Iterable[Write]) -> None:
        """Note it."""
        if self.is_away:
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


def test_the_first_at_a_spot_is_in_front_and_before_the_next_it_is_told_to_be_crowded() -> None:
    session = Session()
    chosen = representatives(session)
    assert ids(chosen.choose(alike(0, 1))) == ["p0"]
    assert session.overfull == []
    assert chosen.choose(alike(1, 4)) == []
    [row] = alike(0, 1)
    assert session.overfull == [(*row.cell, OVERFULL, b"")]
    assert chosen.choose(alike(4, 9)) == []
    assert len(session.overfull) == 1, "it is told once"


def test_plans_made_otherwise_are_put_in_front_beside_them() -> None:
    session = Session()
    chosen = representatives(session)
    chosen.choose(alike(0, 9))
    others = [plan("jps", planner="jps"), plan("wide", parameters={"robot_radius": 0.5}), plan("long", length=9.0)]
    assert ids(chosen.choose(list(plan_rows(others, 8)))) == ["jps", "wide", "long"]


def test_what_goes_beside_is_written_whether_there_is_a_crowd_or_not() -> None:
    session = Session()
    chosen = representatives(session)
    chosen.choose(alike(0, 1), [[("name", ("p0",))]])
    chosen.choose(alike(1, 9), [[("name", ("p1",))]])
    assert session.groups == [("name", ("p0",)), ("name", ("p1",))]


def test_a_crowd_that_could_not_be_told_is_told_the_next_time() -> None:
    session = Session()
    chosen = representatives(session)
    session.is_away = True
    with pytest.raises(ConnectionError):
        chosen.choose(alike(0, REPRESENTATIVES_PER_CELL + 1))
    session.is_away = False
    assert chosen.choose(alike(0, REPRESENTATIVES_PER_CELL + 1)) == [], "they may be there"
    assert len(session.overfull) == 1


def test_a_crowd_is_told_again_as_long_as_plans_come_and_before_it_may_be_swept_away() -> None:
    session, now = Session(), [0.0]
    chosen = representatives(session, now)
    chosen.choose(alike(0, 9))
    now[0] = 0.4 * GRACE
    chosen.choose(alike(9, 10))
    assert len(session.overfull) == 1
    now[0] = 0.6 * GRACE
    chosen.choose(alike(10, 11))
    assert len(session.overfull) == 2
