"""The contract of every ``MapStore`` for versions that wait for a review."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Barrier

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound, QuotaExceeded
from storage.files import reviewed_maps
from storage.ports import MapStore
from storage.records import ConfirmedPlaces, MapReview, ProposedChange, Publication
from tests.support.storage.records import found_map, house, pgm, propose, put_map

ONE, TWO, THREE = (house(image=pgm(value=value)) for value in (0, 100, 254))


def decision(author: str = "ann", **fields: object) -> Publication:
    return Publication("house", author, **({"created": 11.0, "owner": "ann"} | fields))  # type: ignore[arg-type]


@pytest.fixture
def proposed(map_store: MapStore) -> MapReview:
    """Return the review of a second version of a map."""
    put_map(map_store, ONE)
    return propose(map_store, TWO, author="bob", message="a new wall")


def test_a_proposed_version_waits_beside_the_current_one(map_store: MapStore, proposed: MapReview) -> None:
    assert map_store.reviews("house") == [proposed]
    assert (proposed.version, proposed.base, proposed.state) == (TWO.version, ONE.version, "waiting")
    assert (proposed.author, proposed.message, proposed.created) == ("bob", "a new wall", 3.0)
    places = ConfirmedPlaces("tb1", left=((1.25, -0.5),))
    assert proposed.change == ProposedChange(occupied=3, rectangles=((0, 1, 2, 3),), confirmed=places)
    assert found_map(map_store) == ONE
    assert [one.version for one in map_store.versions("house")] == [ONE.version]


def test_a_version_that_waits_can_be_read_but_not_restored(map_store: MapStore, proposed: MapReview) -> None:
    assert found_map(map_store, version=TWO.version).files == TWO.files
    with pytest.raises(NotFound, match=TWO.version):
        map_store.roll_back(TWO.version, decision())


def test_an_approved_version_is_current_with_the_author_of_the_proposal(
    map_store: MapStore, proposed: MapReview
) -> None:
    head = map_store.approve(proposed.number, decision(message="seen it"))
    assert head == map_store.map_head("house")
    assert found_map(map_store).files == TWO.files
    assert (head.version, head.present.author, head.present.message) == (TWO.version, "bob", "a new wall")
    (review,) = map_store.reviews("house")
    assert (review.state, review.closed_by, review.reason, review.closed) == ("approved", "ann", "seen it", 11.0)
    assert [one.version for one in map_store.versions("house")] == [TWO.version, ONE.version]
    assert map_store.approve(proposed.number, decision()) == head


def test_a_refused_version_is_removed_with_the_files_that_no_other_has(
    map_store: MapStore, proposed: MapReview
) -> None:
    review = map_store.refuse(proposed.number, decision(message="it was a person"))
    assert (review.state, review.reason, review.files) == ("refused", "it was a person", {})
    assert map_store.reviews("house") == [review]
    assert map_store.refuse(proposed.number, decision()) == review
    with pytest.raises(NotFound):
        found_map(map_store, version=TWO.version)
    assert found_map(map_store) == ONE  # of the same YAML


def test_a_closed_review_is_not_closed_in_another_way(map_store: MapStore, proposed: MapReview) -> None:
    map_store.refuse(proposed.number, decision())
    with pytest.raises(Conflict, match=f"review {proposed.number} was refused by 'ann' already"):
        map_store.approve(proposed.number, decision())
    later = propose(map_store, THREE)
    map_store.approve(later.number, decision())
    with pytest.raises(Conflict, match="was approved"):
        map_store.refuse(later.number, decision())


def test_an_outdated_proposal_is_approved_by_force_only(map_store: MapStore, proposed: MapReview) -> None:
    put_map(map_store, THREE)
    with pytest.raises(Conflict, match=f"was made from version {ONE.version}, but map 'house' is at version"):
        map_store.approve(proposed.number, decision())
    assert map_store.approve(proposed.number, decision(), force=True).version == TWO.version


def test_the_files_of_the_current_version_are_nothing_to_review(map_store: MapStore, proposed: MapReview) -> None:
    with pytest.raises(Conflict, match="nothing to review"):
        propose(map_store, ONE)
    put_map(map_store, TWO)  # published without the review
    assert map_store.approve(proposed.number, decision(), force=True) == map_store.map_head("house")
    assert len(map_store.versions("house")) == 2


def test_a_repeated_proposal_adds_nothing(map_store: MapStore, proposed: MapReview) -> None:
    assert propose(map_store, TWO, author="eve") == proposed
    assert map_store.reviews("house") == [proposed]


def test_reviews_outlive_other_changes_of_the_map_but_not_the_map(map_store: MapStore, proposed: MapReview) -> None:
    put_map(map_store, THREE)
    map_store.change_map("house", description="hall")
    map_store.remove_versions("house", [ONE.version])
    assert map_store.reviews("house") == [proposed]
    assert found_map(map_store, version=TWO.version).image == TWO.image
    map_store.remove_map("house")
    put_map(map_store, ONE)
    assert map_store.reviews("house") == []


def test_the_versions_that_wait_are_bounded_in_number_and_bytes(
    map_store: MapStore, proposed: MapReview, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reviewed_maps, "MAX_WAITING", 2)
    propose(map_store, THREE)
    with pytest.raises(QuotaExceeded, match="2 versions of map 'house' wait"):
        propose(map_store, house(image=pgm(value=7)))
    map_store.refuse(proposed.number, decision())
    monkeypatch.setattr(reviewed_maps, "MAX_WAITING_BYTES", 200)
    with pytest.raises(QuotaExceeded, match="approve or refuse some first"):
        propose(map_store, house(image=pgm(value=7)))


def test_the_oldest_closed_reviews_are_forgotten(
    map_store: MapStore, proposed: MapReview, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reviewed_maps, "MAX_CLOSED", 1)
    later = propose(map_store, THREE)
    waiting = propose(map_store, house(image=pgm(value=7)))
    for number, review in enumerate((later, proposed)):
        map_store.refuse(review.number, decision(created=float(number)))
    assert [one.number for one in map_store.reviews("house")] == [waiting.number, proposed.number]


def test_one_of_concurrent_decisions_wins(map_store: MapStore, proposed: MapReview) -> None:
    start = Barrier(2)

    def decide(close: Callable[[int, Publication], object]) -> bool:
        start.wait()
        try:
            close(proposed.number, decision())
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(2) as threads:
        approved, refused = threads.map(decide, (map_store.approve, map_store.refuse))
    assert approved != refused
    assert found_map(map_store).version == (TWO if approved else ONE).version


def test_files_proposed_again_during_refusals_are_kept(map_store: MapStore) -> None:
    put_map(map_store, ONE)

    def refuse(number: int) -> None:
        with suppress(Conflict, NotFound):
            map_store.refuse(number, decision())

    with ThreadPoolExecutor(3) as threads:
        for _ in range(4):
            review = propose(map_store, TWO)
            for done in [threads.submit(refuse, review.number), threads.submit(propose, map_store, TWO)]:
                done.result()
    for one in map_store.reviews("house"):
        if one.waits:
            assert found_map(map_store, version=one.version).files == TWO.files


CALLS: list[Callable[[MapStore, int], object]] = [
    lambda store, number: store.approve(number, decision()),
    lambda store, number: store.refuse(number, decision()),
]


@pytest.mark.parametrize("call", CALLS)
def test_unknown_reviews_and_maps_are_not_found(map_store: MapStore, call: Callable[[MapStore, int], object]) -> None:
    with pytest.raises(NotFound, match="map 'house'"):
        call(map_store, 1)
    put_map(map_store, ONE)
    with pytest.raises(NotFound, match="review of map 'house': '99'"):
        call(map_store, 99)
    with pytest.raises(NotFound):
        map_store.reviews("nowhere")


def test_proposals_need_a_map_of_the_same_owner_and_valid_names(map_store: MapStore) -> None:
    with pytest.raises(NotFound):
        propose(map_store, ONE, base=TWO.version)
    put_map(map_store, ONE)
    with pytest.raises(Conflict, match="belongs to another user"):
        propose(map_store, house(owner="bob", image=pgm(value=7)))
    with pytest.raises(InvalidInput):
        propose(map_store, TWO, base="../x")
    with pytest.raises(Conflict, match="not at version"):
        propose(map_store, TWO, if_match=THREE.version)
    with pytest.raises(Conflict):
        map_store.approve(propose(map_store, TWO).number, decision(owner="bob"))
