"""The contract of every ``MapStore`` for versions that keep the zones of the map, and for versions with others."""

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import MapStore
from storage.records import MapReview, Publication
from storage.versions import ALL_BUT_ZONES, ONLY_ZONES
from tests.support.storage.records import GivenMap, found_map, house, pgm, propose, put_map

HALL, YARD = b'{"zones": "of the hall"}', b'{"zones": "of the yard"}'
WALL, BT = pgm(value=0), b"# Octomap OcTree binary file\n..."


def zones_only(zones: bytes | None) -> GivenMap:
    return GivenMap("house", "ann", None, None, zones=zones)


def test_a_version_without_zones_keeps_those_of_the_map_if_it_should(map_store: MapStore) -> None:
    put_map(map_store, house(zones=HALL))
    head = put_map(map_store, house(image=WALL), ONLY_ZONES)
    assert found_map(map_store).files == house(image=WALL, zones=HALL).files
    assert head.version == house(image=WALL, zones=HALL).version
    assert put_map(map_store, house(image=WALL), ONLY_ZONES) == head
    put_map(map_store, house(image=WALL, zones=YARD), ONLY_ZONES)
    assert found_map(map_store).zones == YARD
    put_map(map_store, house(image=WALL))
    assert found_map(map_store).zones is None


def test_zones_are_not_kept_where_there_is_no_grid(map_store: MapStore) -> None:
    put_map(map_store, house(zones=HALL))
    put_map(map_store, house(image=None, octomap=BT), ONLY_ZONES)
    assert found_map(map_store).files == {"octomap": BT}


def test_zones_change_alone(map_store: MapStore) -> None:
    first = put_map(map_store, house(octomap=BT, posegraph=BT))
    second = put_map(map_store, zones_only(HALL), ALL_BUT_ZONES)
    assert found_map(map_store).files == house(octomap=BT, posegraph=BT, zones=HALL).files
    assert put_map(map_store, zones_only(HALL), ALL_BUT_ZONES) == second
    assert put_map(map_store, zones_only(None), ALL_BUT_ZONES).version == first.version
    assert found_map(map_store, version=second.version).zones == HALL
    assert [one.version for one in map_store.versions("house")] == [first.version, second.version, first.version]


def test_zones_of_an_earlier_version_come_back_with_it(map_store: MapStore) -> None:
    first = put_map(map_store, house(zones=HALL))
    put_map(map_store, house(zones=YARD))
    map_store.roll_back(first.version, Publication("house", "ann", 9.0))
    assert found_map(map_store).zones == HALL


def test_zones_need_a_map_with_a_grid(map_store: MapStore) -> None:
    with pytest.raises(NotFound):
        put_map(map_store, zones_only(HALL), ALL_BUT_ZONES)
    assert map_store.maps() == []
    put_map(map_store, house(image=None, octomap=BT))
    with pytest.raises(InvalidInput, match="zones need a yaml with its image"):
        put_map(map_store, zones_only(HALL), ALL_BUT_ZONES)


def test_kept_zones_stay_when_the_version_that_had_them_is_removed(map_store: MapStore) -> None:
    first = put_map(map_store, house(zones=HALL))
    put_map(map_store, house(image=WALL), ONLY_ZONES)
    map_store.remove_versions("house", [first.version])
    assert found_map(map_store).files == house(image=WALL, zones=HALL).files


def decide() -> Publication:
    return Publication("house", "ann", 11.0, owner="ann")


@pytest.fixture
def proposed(map_store: MapStore) -> MapReview:
    """Return the review of another grid, which keeps the zones of the map."""
    put_map(map_store, house(zones=HALL))
    return propose(map_store, house(image=WALL), keeps=ONLY_ZONES)


def test_a_proposed_version_has_the_zones_of_the_map(map_store: MapStore, proposed: MapReview) -> None:
    assert proposed.version == house(image=WALL, zones=HALL).version
    assert found_map(map_store, version=proposed.version).zones == HALL
    assert map_store.approve(proposed.number, decide()).version == proposed.version


@pytest.mark.parametrize("zones", [YARD, None], ids=["changed", "removed"])
def test_a_proposed_version_follows_zones_that_change_while_it_waits(
    map_store: MapStore, proposed: MapReview, zones: bytes | None
) -> None:
    changed = put_map(map_store, zones_only(zones), ALL_BUT_ZONES)
    (review,) = map_store.reviews("house")
    assert (review.base, review.version) == (changed.version, house(image=WALL, zones=zones).version)
    assert propose(map_store, house(image=WALL), keeps=ONLY_ZONES) == review
    assert map_store.approve(proposed.number, decide()).version == review.version
    assert found_map(map_store).files == house(image=WALL, zones=zones).files


def test_a_proposed_version_follows_a_roll_back_of_zones(map_store: MapStore, proposed: MapReview) -> None:
    put_map(map_store, zones_only(YARD), ALL_BUT_ZONES)
    map_store.roll_back(house(zones=HALL).version, decide())
    assert map_store.reviews("house") == [proposed]


def test_an_outdated_version_follows_zones_but_stays_outdated(map_store: MapStore, proposed: MapReview) -> None:
    put_map(map_store, house(image=pgm(value=205), zones=YARD))
    (review,) = map_store.reviews("house")
    assert (review.base, review.version) == (proposed.base, house(image=WALL, zones=YARD).version)
    with pytest.raises(Conflict, match="was made from version"):
        map_store.approve(proposed.number, decide())
    map_store.approve(proposed.number, decide(), force=True)
    assert found_map(map_store).files == house(image=WALL, zones=YARD).files


def test_other_reviews_follow_the_zones_of_an_approved_version(map_store: MapStore, proposed: MapReview) -> None:
    own = propose(map_store, house(zones=YARD))
    map_store.approve(own.number, decide())
    approved, review = sorted(map_store.reviews("house"), key=lambda one: one.number == proposed.number)
    assert approved.state == "approved"
    assert (review.base, review.version) == (house(zones=YARD).version, house(image=WALL, zones=YARD).version)
    assert map_store.approve(review.number, decide()).version == review.version


def test_a_proposal_with_zones_of_its_own_keeps_them(map_store: MapStore) -> None:
    base = put_map(map_store, house())
    review = propose(map_store, house(image=WALL, zones=YARD))
    put_map(map_store, zones_only(HALL), ALL_BUT_ZONES)
    (after,) = map_store.reviews("house")
    assert (after, after.base) == (review, base.version)
