"""The disk becomes full during writes: it is reported, acknowledged writes are complete, others are absent."""

import asyncio
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.shared_logins import LocalLogins
from ppaas.errors import NotAuthenticated, Unavailable
from storage.disk_space import RefusedTokenFile
from storage.files.store import FileMapStore
from storage.sqlite.store import SqliteStore
from storage.store_and_forward.plan_outbox import PlanOutbox
from tests.support.sources import ROOT
from tests.support.storage.records import found_map, pgm, plan
from tests.support.waiting import until

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


REVOKER = """
import asyncio, resource, sys
from contextlib import suppress
from pathlib import Path
from endpoints.accounts.accounts import Accounts
from endpoints.accounts.shared_logins import LocalLogins
from endpoints.accounts.tokens import token_id
from ppaas.errors import Unavailable
from storage.disk_space import SLOT, SLOTS, RefusedTokenFile
from storage.records import Token
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import robot

async def main(folder):
    file, store = RefusedTokenFile(folder), SqliteStore(folder / "store.sqlite")
    file.open()
    accounts = Accounts(store, logins=LocalLogins(file=file))
    for user in ("ann", "bob"):
        await accounts.register(user, "correct horse")
    print(token := await accounts.login("ann", "correct horse"))
    resource.setrlimit(resource.RLIMIT_FSIZE, (SLOT * SLOTS, SLOT * SLOTS))  # what there is can be written in place
    for size in (20_000, 1):
        with suppress(Unavailable):
            for number in range(10_000):
                store.put_robot(robot(f"p{number}", description=size * "x"))
    with suppress(Unavailable):
        for number in range(10_000):  # the room that is too small for a robot
            store.add_token(Token(f"t{number}", "bob", 1e12))
    await accounts.revoke("ann", token_id(token))
    print("acknowledged", token_id(token) in [one.hash for one in store.tokens("ann")], flush=True)

asyncio.run(main(Path(sys.argv[1])))
"""


async def test_a_token_that_was_revoked_on_a_full_disk_stays_revoked_after_a_restart(tmp_path: Path) -> None:
    command = [sys.executable, "-c", REVOKER, str(tmp_path)]
    done = await asyncio.to_thread(
        subprocess.run, command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    token, acknowledged = done.stdout.splitlines()
    assert acknowledged == "acknowledged True", "the store still has it"
    file = RefusedTokenFile(tmp_path)
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        accounts = Accounts(store, logins=LocalLogins(file=file))
        accounts._tokens._revocations._retry = 0.01
        await accounts.refuse(file.open())
        with pytest.raises(NotAuthenticated):
            await accounts.authenticate(token)
        await until(lambda: not store.tokens("ann") and not RefusedTokenFile(tmp_path).open())
        with pytest.raises(NotAuthenticated):
            await accounts.authenticate(token)
        accounts.close()
