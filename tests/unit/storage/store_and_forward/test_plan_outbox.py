"""The outbox stores plans durably, in order, up to its maximum size."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import cast

import pytest

from ppaas.errors import Unavailable
from storage.store_and_forward.plan_outbox import PlanOutbox
from tests.support.sources import ROOT
from tests.support.storage.records import plan

# Prints the number of each accepted plan, until it is killed.
WRITER = """
import sys
from pathlib import Path
from storage.store_and_forward.plan_outbox import PlanOutbox
from tests.support.storage.records import plan

outbox, number = PlanOutbox(Path(sys.argv[1])), 0
while True:
    outbox.put([plan(f"p{number}")])
    print(number, flush=True)
    number += 1
"""


@pytest.fixture
def outbox(tmp_path: Path) -> PlanOutbox:
    return PlanOutbox(tmp_path / "outbox.sqlite")


def test_queued_plans_are_returned_in_order(outbox: PlanOutbox) -> None:
    assert outbox.is_empty()
    assert outbox.put([plan("b"), plan("a")]) == 2
    assert outbox.put([plan("c"), plan("b", cost=1.0)]) == 1
    assert list(outbox.oldest(9).values()) == [plan("b"), plan("a"), plan("c")]
    assert list(outbox.oldest(2).values()) == [plan("b"), plan("a")]
    assert len(outbox) == 3


def test_sent_plans_are_removed_and_newer_ones_stay(outbox: PlanOutbox) -> None:
    outbox.put([plan("a"), plan("b")])
    sent = list(outbox.oldest(9))
    outbox.put([plan("c")])
    outbox.remove(sent)
    assert list(outbox.oldest(9).values()) == [plan("c")]


def test_sequence_numbers_are_never_reused(outbox: PlanOutbox) -> None:
    outbox.put([plan("a")])
    first = list(outbox.oldest(1))
    outbox.remove(first)
    outbox.put([plan("b")])
    outbox.remove(first)
    assert list(outbox.oldest(9).values()) == [plan("b")]


def test_a_plan_is_found_by_its_id_until_it_is_forgotten(outbox: PlanOutbox) -> None:
    outbox.put([plan("a")])
    assert outbox.find("a") == plan("a")
    assert outbox.forget("a")
    assert not outbox.forget("a")
    assert outbox.find("a") is None


def test_queued_plans_survive_a_restart(outbox: PlanOutbox, tmp_path: Path) -> None:
    outbox.put([plan("a")])
    outbox.close()
    assert list(PlanOutbox(tmp_path / "outbox.sqlite").oldest(9).values()) == [plan("a")]


def test_a_full_outbox_refuses_plans_and_keeps_the_accepted_ones(tmp_path: Path) -> None:
    outbox = PlanOutbox(tmp_path / "outbox.sqlite", max_bytes=300_000)
    taken = 0
    with pytest.raises(Unavailable, match="the outbox is full"):
        while True:
            outbox.put([plan(f"p{taken}", poses=bytes(56 * 300))])
            taken += 1
    assert taken > 10
    assert [record.id for record in outbox.oldest(99).values()] == [f"p{number}" for number in range(taken)]
    outbox.remove(list(outbox.oldest(2)))
    outbox.put([plan("more", poses=bytes(56 * 300))])


def test_accepted_plans_survive_a_killed_process(tmp_path: Path) -> None:
    path = tmp_path / "outbox.sqlite"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, cwd=ROOT)
    assert writer.stdout is not None
    taken = [int(writer.stdout.readline()) for _ in range(20)]
    writer.kill()
    taken += [int(line) for line in writer.stdout.read().splitlines() if line]
    writer.wait()
    kept = [record.id for record in PlanOutbox(path).oldest(10**6).values()]
    assert kept[: len(taken)] == [f"p{number}" for number in taken]
    assert len(kept) - len(taken) <= 1, "at most the one that was being taken"


def test_a_damaged_plan_is_dropped_and_one_of_another_release_waits_for_it(
    outbox: PlanOutbox, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    outbox.put([plan("a", planner=cast(str, 5)), plan("b"), plan("c"), plan("d", planner=cast(str, 5))])
    with closing(sqlite3.connect(tmp_path / "outbox.sqlite", isolation_level=None)) as connection:
        connection.execute("UPDATE plans SET record = x'81' WHERE id = 'b'")
    assert list(outbox.oldest(1).values()) == [plan("c")]
    assert list(outbox.oldest(9).values()) == [plan("c")]
    outbox.remove(list(outbox.oldest(9)))
    assert outbox.oldest(9) == {}
    assert len(outbox) == 2, "those of another release"
    assert outbox.is_empty(), "there is nothing to send"
    assert "outbox/a is a record of another release" in caplog.text
    assert "outbox/b is damaged" in caplog.text
    assert len(PlanOutbox(tmp_path / "outbox.sqlite")) == 2
