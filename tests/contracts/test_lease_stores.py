"""The contract of every ``LeaseStore``."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import InvalidInput
from storage.ports import Store
from storage.records import LONGEST_HOLDER, Lease
from tests.support.storage.records import NOT_NAMES

NEVER_TAKEN = Lease("master")
FIRST = Lease("master", "a", 1)


def test_a_lease_that_was_never_taken_has_no_holder(store: Store) -> None:
    assert store.lease("master") == NEVER_TAKEN


def test_a_lease_is_taken_renewed_and_released(store: Store) -> None:
    before = NEVER_TAKEN
    for after in (FIRST, Lease("master", "a", 1, 1), Lease("master", "a", 1, 2), Lease("master", "", 1, 3)):
        assert store.change_lease(after, instead_of=before)
        assert store.lease("master") == after
        before = after
    assert store.change_lease(Lease("master", "b", 2), instead_of=before)
    assert store.lease("other") == Lease("other")


@pytest.mark.parametrize(
    "instead_of",
    [NEVER_TAKEN, Lease("master", "b", 1, 1), Lease("master", "a", 1), Lease("master", "a", 0, 1)],
    ids=["never taken", "another holder", "an earlier beat", "an earlier epoch"],
)
def test_a_lease_that_has_changed_stays(store: Store, instead_of: Lease) -> None:
    held = Lease("master", "a", 1, 1)
    assert store.change_lease(FIRST, instead_of=NEVER_TAKEN)
    assert store.change_lease(held, instead_of=FIRST)
    assert not store.change_lease(Lease("master", "c", 2), instead_of=instead_of)
    assert store.lease("master") == held


def test_of_many_candidates_at_once_one_takes_each_epoch(store: Store) -> None:
    with ThreadPoolExecutor(4) as threads:
        for epoch in range(1, 4):
            seen = store.lease("master")
            candidates = [Lease("master", name, epoch) for name in "abcd"]
            took = list(threads.map(lambda lease, seen=seen: store.change_lease(lease, instead_of=seen), candidates))
            assert took.count(True) == 1
            assert store.lease("master") == candidates[took.index(True)]


def test_a_lease_never_goes_back(store: Store) -> None:
    for lease in (Lease("master", "a", 1), Lease("master", "a", 0, 7), Lease("other", "a", 2)):
        with pytest.raises(InvalidInput):
            store.change_lease(lease, instead_of=FIRST)
    with pytest.raises(InvalidInput):
        store.change_lease(Lease("master", "a" * (LONGEST_HOLDER + 1), 2), instead_of=FIRST)
    assert store.lease("master") == NEVER_TAKEN


@pytest.mark.parametrize("name", NOT_NAMES)
def test_the_name_of_a_lease_is_a_name(store: Store, name: str) -> None:
    with pytest.raises(InvalidInput):
        store.lease(name)
    with pytest.raises(InvalidInput):
        store.change_lease(Lease(name, "a", 1), instead_of=Lease(name))
