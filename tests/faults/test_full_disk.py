"""The disk becomes full during writes: it is reported, acknowledged writes are complete, others are absent."""

import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.files.store import FileMapStore
from storage.sqlite.store import SqliteStore
from storage.store_and_forward.plan_outbox import PlanOutbox
from tests.support.sources import ROOT
from tests.support.storage.records import found_map, pgm, plan

# A limit of 2 MB per file acts as a full disk. Prints the number of each accepted write, and the error.
WRITER = """
import resource, sys
from pathlib import Path
import numpy as np
from ppaas.errors import Unavailable
from storage.store_and_forward.plan_outbox import PlanOutbox
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan, robot

kind = sys.argv[1]
store = (PlanOutbox if kind == "outbox" else SqliteStore)(Path(sys.argv[2]))
random = np.random.default_rng(1)

def a_plan(number):
    return plan(f"p{number}", poses=random.normal(size=(100, 7)).tobytes())

keep = {
    "outbox": lambda number: store.put([a_plan(number)]),
    "plans": lambda number: store.add_plan(a_plan(number)),
    "robots": lambda number: store.put_robot(robot(f"p{number}", description=random.bytes(2000).hex())),
}[kind]
resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))
for number in range(10_000):
    try:
        keep(number)
    except Unavailable as error:
        print(error)
        break
    print(number, flush=True)
"""


@pytest.mark.parametrize("kind", ["outbox", "plans", "robots"])
def test_writes_accepted_before_the_disk_was_full_are_complete(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "file.sqlite"
    command = [sys.executable, "-c", WRITER, kind, str(path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    *taken, error = done.stdout.splitlines()
    assert "disk" in error and "space" in error
    assert len(taken) > 10
    names = [f"p{number}" for number in taken]
    kept = sizes(kind, path)
    assert set(names) <= set(kept)
    assert len(kept) - len(names) <= 1, "at most the one being written"
    assert set(kept.values()) == {4000 if kind == "robots" else 5600}


def sizes(kind: str, path: Path) -> dict[str, int]:
    """Return the size of each stored record, by its id."""
    if kind == "outbox":
        return {record.id: len(record.poses) for record in PlanOutbox(path).oldest(10_000).values()}
    with closing(SqliteStore(path)) as store:
        if kind == "robots":
            return {one.id: len(one.description) for one in store.robots("ann")}
        return {head.id: len(store.plan(head.id).poses) for head in store.plans("house")}


PUBLISHER = """
import resource, sys
from pathlib import Path
from ppaas.errors import Unavailable
from storage.files.store import FileMapStore
from tests.support.storage.records import house, pgm, put_map

store = FileMapStore(Path(sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
for number in range(1, 10_000):
    try:
        print(put_map(store, house(image=pgm(1000, 15 * number))).version, flush=True)
    except Unavailable as error:
        print(error)
        break
"""


def test_a_map_that_does_not_fit_is_not_published_and_others_stay(tmp_path: Path) -> None:
    command = [sys.executable, "-c", PUBLISHER, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    *published, error = done.stdout.splitlines()
    assert "image" in error
    assert len(published) == 6
    store = FileMapStore(tmp_path)
    assert [one.version for one in store.versions("house")] == published[::-1]
    for number, version in enumerate(published, 1):
        assert found_map(store, version=version).image == pgm(1000, 15 * number)
    assert list((tmp_path / ".incoming").iterdir()) == []


def test_an_outbox_accepts_plans_again_once_there_is_space(tmp_path: Path) -> None:
    outbox = PlanOutbox(tmp_path / "outbox.sqlite", max_bytes=100_000)
    with pytest.raises(Unavailable):
        for number in range(100):
            outbox.put([plan(f"p{number}", poses=bytes(5600))])
    outbox.remove(list(outbox.oldest(99)))
    assert outbox.put([plan("more", poses=bytes(5600))]) == 1
