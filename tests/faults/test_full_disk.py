"""The disk is full in the middle of writes: it is told, what was acknowledged is there, and nothing half-written is."""

import subprocess
import sys
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.outbox import Outbox
from storage.sqlite import SqliteStore
from tests.support.records import plan
from tests.support.sources import ROOT

# Files may grow to 2 MB and no further, which a process is told as of a full disk. Tells of what was taken.
WRITER = """
import resource, sys
from pathlib import Path
import numpy as np
from ppaas.errors import Unavailable
from storage.outbox import Outbox
from storage.sqlite import SqliteStore
from tests.support.records import plan

store = {"outbox": Outbox, "store": SqliteStore}[sys.argv[1]](Path(sys.argv[2]))
keep = {"outbox": lambda one: store.put([one]), "store": lambda one: store.add_plan(one)}[sys.argv[1]]
resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))
random = np.random.default_rng(1)
for number in range(10_000):
    try:
        keep(plan(f"p{number}", poses=random.normal(size=(100, 7)).tobytes()))
    except Unavailable as error:
        print(error)
        break
    print(number, flush=True)
"""


@pytest.mark.parametrize("kind", ["outbox", "store"])
def test_what_was_taken_before_the_disk_was_full_is_there_and_whole(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "file.sqlite"
    command = [sys.executable, "-c", WRITER, kind, str(path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    *taken, told = done.stdout.splitlines()
    assert "disk" in told and "space" in told
    assert len(taken) > 10
    names = [f"p{number}" for number in taken]
    if kind == "outbox":
        kept = {record.id: record for record in Outbox(path).oldest(10_000).values()}
    else:
        store = SqliteStore(path)
        kept = {head.id: store.plan(head.id) for head in store.plans("house")}
        store.close()
    assert set(names) <= set(kept)
    assert len(kept) - len(names) <= 1, "at most the one that was being taken"
    assert all(len(record.poses) == 5600 for record in kept.values())


def test_a_disk_that_has_room_again_is_written_again(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path / "outbox.sqlite", most_bytes=100_000)
    with pytest.raises(Unavailable):
        for number in range(100):
            outbox.put([plan(f"p{number}", poses=bytes(5600))])
    outbox.remove(list(outbox.oldest(99)))
    assert outbox.put([plan("more", poses=bytes(5600))]) == 1
