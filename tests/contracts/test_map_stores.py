"""The contract of every ``MapStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from threading import Barrier

import msgspec
import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import MapStore
from storage.records import MapFile, Publication
from storage.versions import map_version
from tests.support.storage.records import NOT_NAMES, GivenMap, found_map, house, pgm, put_map

BT = b"# Octomap OcTree binary file\n..."
ZONES = b'{"type":"FeatureCollection","features":[]}'


def publication(author: str = "ann", **fields: object) -> Publication:
    return Publication("house", author, **({"created": 9.0} | fields))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "given",
    [
        house(readers=("bob", "*")),
        house(octomap=BT),
        house(image=None, octomap=BT),
        house(image=b""),
        house(posegraph=BT),
        house(zones=ZONES),
    ],
    ids=["grid", "grid and octomap", "octomap", "empty file", "grid and posegraph", "grid and zones"],
)
def test_a_map_is_returned_as_published(map_store: MapStore, given: GivenMap) -> None:
    head = put_map(map_store, given, message="first walk")
    assert found_map(map_store) == given
    assert head == map_store.map_head("house")
    assert (head.version, head.present.author, head.present.message) == (given.version, "ann", "first walk")
    assert {part: file.size for part, file in head.present.files.items()} == {
        part: len(data) for part, data in given.files.items()
    }


def test_only_the_requested_files_are_opened(map_store: MapStore) -> None:
    put_map(map_store, house(octomap=BT))
    with map_store.open_map("house", only=("octomap",)) as opened:
        assert {part: bytes(data) for part, data in opened.buffers.items()} == {"octomap": BT}
        assert opened.paths["octomap"].read_bytes() == BT
        with pytest.raises(NotFound, match="image"):
            opened.buffer("image")


def test_open_files_stay_readable_after_the_map_is_removed(map_store: MapStore) -> None:
    put_map(map_store, house())
    with map_store.open_map("house") as opened:
        map_store.remove_map("house")
        assert bytes(opened.buffer("image")) == pgm()


@pytest.mark.parametrize(
    "parts",
    [(), ("yaml",), ("image",), ("yaml", "octomap"), ("posegraph",), ("octomap", "posegraph"), ("octomap", "zones")],
)
def test_an_upload_without_a_required_file_is_refused(map_store: MapStore, parts: tuple[str, ...]) -> None:
    with map_store.stage() as upload:
        for part in parts:
            upload.add(part, [b"x"])
        with pytest.raises(InvalidInput, match="a yaml with its image"):
            map_store.publish(upload, publication())
    assert map_store.maps() == []


def test_each_known_part_is_accepted_once(map_store: MapStore) -> None:
    with map_store.stage() as upload:
        upload.add("yaml", [b"a", b"b"])
        for part in ("yaml", "../yaml", "readme"):
            with pytest.raises(InvalidInput, match="one each of"):
                upload.add(part, [b"x"])
        assert bytes(upload.buffer("yaml")) == b"ab"


def test_the_last_published_version_is_current(map_store: MapStore) -> None:
    first, second = house(image=pgm(value=0)), house(image=pgm(value=254))
    assert first.version != second.version
    for record in (first, second, first):
        put_map(map_store, record)
        assert found_map(map_store) == record


def test_publishing_the_current_version_changes_only_its_description(map_store: MapStore) -> None:
    head = put_map(map_store, house(), message="first walk")
    again = put_map(map_store, house(created=8.0, description="hall"))
    assert (again.present, again.description) == (head.present, "hall")
    assert map_store.versions("house") == [head.present]


def test_publishing_the_current_version_replaces_its_message(map_store: MapStore) -> None:
    first = put_map(map_store, house(), message="first walk").present
    again = put_map(map_store, house(created=8.0), message="surveyed in May").present
    assert again == msgspec.structs.replace(first, message="surveyed in May")
    assert map_store.versions("house") == [again]
    second = put_map(map_store, house(image=pgm(value=7)), message="a new wall").present
    assert map_store.versions("house") == [second, again]


def test_readers_change_without_a_new_version(map_store: MapStore) -> None:
    put_map(map_store, house(readers=("bob",)))
    put_map(map_store, house(readers=()))
    assert found_map(map_store).readers == ()


def test_heads_are_sorted_by_id(map_store: MapStore) -> None:
    for map_id in ("depot", "house", "Attic"):
        put_map(map_store, house(map_id))
    assert map_store.maps() == [map_store.map_head(map_id) for map_id in ("Attic", "depot", "house")]


def test_only_readable_maps_are_listed_for_a_user(map_store: MapStore) -> None:
    for map_id, owner, readers in (("a", "ann", ()), ("b", "ann", ("bob",)), ("c", "ann", ("*",)), ("d", "bob", ())):
        put_map(map_store, house(map_id, owner=owner, readers=readers))
    seen = {user: [head.id for head in map_store.maps(user)] for user in ("ann", "bob", "carl")}
    assert seen == {"ann": ["a", "b", "c"], "bob": ["b", "c", "d"], "carl": ["c"]}
    assert [head.id for head in map_store.maps("bob", after="b", limit=1)] == ["c"]


def test_every_version_is_kept_and_listed_newest_first(map_store: MapStore) -> None:
    one, two = house(image=pgm(value=1), created=1.0), house(image=pgm(value=2), created=2.0)
    first = put_map(map_store, one, message="as built").present
    map_store.change_map("house", description="hall")
    second = put_map(map_store, two, author="bob", message="a door was opened").present
    assert [(one.created, one.author, one.message) for one in map_store.versions("house")] == [
        (2.0, "bob", "a door was opened"),
        (1.0, "ann", "as built"),
    ]
    assert map_store.versions("house", limit=1) == [second]
    assert map_store.versions("house", before=second.number) == [first]
    assert map_store.versions("house", before=first.number) == []
    assert found_map(map_store, version=one.version).files == one.files
    with map_store.open_map("house", first.version) as opened:
        assert opened.record.present == first
    with pytest.raises(NotFound, match="version of map 'house': 'f"):
        found_map(map_store, version="f" * 64)
    with pytest.raises(InvalidInput):
        found_map(map_store, version="../x")


def test_a_restored_version_is_current_and_marked_as_restored(map_store: MapStore) -> None:
    one, two = house(image=pgm(value=1), created=1.0), house(image=pgm(value=2), created=2.0)
    for given in (one, two):
        put_map(map_store, given)
    head = map_store.roll_back(one.version, publication("bob", owner="ann", message="the door is closed"))
    assert found_map(map_store).files == one.files
    assert head == map_store.map_head("house")
    assert (head.version, head.present.author, head.present.message) == (one.version, "bob", "the door is closed")
    assert [(was.version, was.restored) for was in map_store.versions("house")] == [
        (one.version, True),
        (two.version, False),
        (one.version, False),
    ]
    with map_store.open_map("house", one.version) as opened:
        assert opened.record == head
    assert map_store.roll_back(one.version, publication("ann")) == head  # it is current already


def test_an_unknown_version_cannot_be_restored(map_store: MapStore) -> None:
    with pytest.raises(NotFound):
        map_store.roll_back("f" * 64, publication())
    put_map(map_store, house())
    with pytest.raises(NotFound, match="version of map"):
        map_store.roll_back("f" * 64, publication())
    with pytest.raises(Conflict):
        map_store.roll_back(house().version, publication("bob"))


def test_publishing_with_an_outdated_if_match_conflicts(map_store: MapStore) -> None:
    one, two, three = (house(image=pgm(value=value)) for value in (1, 2, 3))
    with pytest.raises(Conflict, match="does not exist"):
        put_map(map_store, one, if_match=two.version)
    put_map(map_store, one)
    put_map(map_store, two, if_match=one.version)
    with pytest.raises(Conflict, match=f"at version {two.version}, not at version {one.version}"):
        put_map(map_store, three, if_match=one.version)
    with pytest.raises(Conflict):
        map_store.roll_back(one.version, publication(if_match=one.version))
    assert found_map(map_store).version == two.version


def test_concurrent_publications_are_all_kept(map_store: MapStore) -> None:
    put_map(map_store, house(image=pgm(value=0)))
    start = Barrier(6)

    def publish(value: int) -> str:
        start.wait()
        if value == 6:
            map_store.change_map("house", description="seen")
        return put_map(map_store, house(image=pgm(value=value)), description=None).version

    with ThreadPoolExecutor(6) as threads:
        made = list(threads.map(publish, range(1, 7)))
    assert sorted(one.version for one in map_store.versions("house")[:6]) == sorted(made)
    assert map_store.map_head("house").description == "seen"
    for version in made:
        assert found_map(map_store, version=version).version == version


def test_one_of_concurrent_publications_with_the_same_if_match_succeeds(map_store: MapStore) -> None:
    first = put_map(map_store, house(image=pgm(value=0))).version
    start = Barrier(5)

    def publish(value: int) -> bool:
        start.wait()
        try:
            put_map(map_store, house(image=pgm(value=value)), if_match=first)
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(5) as threads:
        assert sum(threads.map(publish, range(1, 6))) == 1
    assert len(map_store.versions("house")) == 2


def test_a_removed_version_is_neither_listed_nor_found_and_others_keep_their_files(map_store: MapStore) -> None:
    first, second, third = (house(image=pgm(value=value)) for value in (0, 100, 254))
    for one in (first, second, third):
        put_map(map_store, one)
    map_store.change_map("house", description="told while the third was current")
    map_store.remove_versions("house", [second.version])
    assert [one.version for one in map_store.versions("house")] == [third.version, first.version]
    assert found_map(map_store, version=first.version).image == first.image  # of the same YAML
    assert found_map(map_store).image == third.image
    for refused in (
        lambda: found_map(map_store, version=second.version),
        lambda: map_store.roll_back(second.version, publication()),
        lambda: map_store.remove_versions("house", [second.version]),
    ):
        with pytest.raises(NotFound, match=second.version):
            refused()


def test_all_publications_of_a_removed_version_are_removed(map_store: MapStore) -> None:
    first, second = house(image=pgm(value=0)), house(image=pgm(value=254))
    put_map(map_store, first)
    map_store.change_map("house", readers=("bob",))
    put_map(map_store, second)
    map_store.roll_back(first.version, publication())
    map_store.change_map("house", readers=("eve",))
    map_store.roll_back(second.version, publication())
    map_store.remove_versions("house", [first.version])
    assert [one.version for one in map_store.versions("house")] == [second.version] * 2
    assert map_store.map_head("house").readers == ("eve",)


def test_several_versions_are_removed_at_once_or_none(map_store: MapStore) -> None:
    maps = [house(image=pgm(value=value)) for value in (0, 50, 100, 254)]
    for one in maps:
        put_map(map_store, one)
    versions = [one.version for one in maps]
    with pytest.raises(NotFound):
        map_store.remove_versions("house", [versions[0], 64 * "0"])
    assert len(map_store.versions("house")) == 4
    map_store.remove_versions("house", versions[:3])
    assert [one.version for one in map_store.versions("house")] == versions[3:]
    map_store.remove_versions("house", [])


def test_the_current_version_cannot_be_removed(map_store: MapStore) -> None:
    head = put_map(map_store, house())
    with pytest.raises(Conflict, match="is the current one of map 'house': publish or roll back to another first"):
        map_store.remove_versions("house", [head.version])
    assert found_map(map_store) == house()


def test_a_removed_version_can_be_published_again(map_store: MapStore) -> None:
    first, second = house(image=pgm(value=0)), house(image=pgm(value=254))
    for one in (first, second):
        put_map(map_store, one)
    map_store.remove_versions("house", [first.version])
    put_map(map_store, first)
    assert found_map(map_store) == first
    assert [one.version for one in map_store.versions("house")] == [first.version, second.version]


def test_publications_during_removals_keep_their_files(map_store: MapStore) -> None:
    maps = [house(image=pgm(value=value)) for value in (0, 100, 254)]
    for one in maps:
        put_map(map_store, one)

    def publish(number: int) -> None:
        put_map(map_store, maps[number % 2])
        put_map(map_store, maps[2])

    def remove(number: int) -> None:
        with suppress(Conflict, NotFound):
            map_store.remove_versions("house", [maps[number % 2].version])

    with ThreadPoolExecutor(4) as threads:
        for done in [threads.submit(work, number) for number in range(6) for work in (publish, remove)]:
            done.result()
    for version in {one.version for one in map_store.versions("house")}:
        assert found_map(map_store, version=version).version == version


def test_a_removed_map_is_published_again_without_its_old_versions(map_store: MapStore) -> None:
    put_map(map_store, house(image=pgm(value=1)))
    map_store.remove_map("house")
    put_map(map_store, house(image=pgm(value=2)))
    assert [one.version for one in map_store.versions("house")] == [house(image=pgm(value=2)).version]


def test_readers_and_description_change_without_the_files(map_store: MapStore) -> None:
    put_map(map_store, house(readers=("bob",)))
    changed = map_store.change_map("house", description="the ground floor")
    assert (changed.readers, changed.description) == (("bob",), "the ground floor")
    assert changed == map_store.map_head("house")
    map_store.change_map("house", readers=())
    assert found_map(map_store) == house(description="the ground floor")
    assert found_map(map_store, version=house().version).description == "the ground floor"


def test_traffic_of_a_map_stays_with_its_next_versions(map_store: MapStore) -> None:
    put_map(map_store, house())
    assert not map_store.map_head("house").traffic
    assert map_store.change_map("house", traffic=True).traffic
    assert map_store.change_map("house", description="a hall").traffic
    put_map(map_store, house(image=pgm(value=2)))
    assert map_store.map_head("house").traffic
    assert not map_store.change_map("house", traffic=False).traffic


@pytest.mark.parametrize("text", ["'; DROP TABLE maps; --", '"}{', "../../etc", "\0\u202e", "ä" * 256])
def test_texts_are_stored_unchanged(map_store: MapStore, text: str) -> None:
    put_map(map_store, house(description=text), message=text)
    assert map_store.map_head("house").description == text
    assert map_store.versions("house")[0].message == text


def test_a_map_keeps_its_owner(map_store: MapStore) -> None:
    put_map(map_store, house(owner="ann"))
    with pytest.raises(Conflict, match="house"):
        put_map(map_store, house(owner="bob"))
    assert found_map(map_store).owner == "ann"


def test_one_of_concurrent_first_publishers_owns_the_map(map_store: MapStore) -> None:
    start = Barrier(6)

    def publish(owner: str) -> str | None:
        start.wait()
        try:
            put_map(map_store, house(owner=owner))
        except Conflict:
            return None
        return owner

    with ThreadPoolExecutor(6) as threads:
        winners = [owner for owner in threads.map(publish, "abcdef") if owner]
    assert winners == [map_store.map_head("house").owner]


def test_a_removed_map_is_not_found_and_its_id_is_free(map_store: MapStore) -> None:
    put_map(map_store, house(owner="ann"))
    map_store.remove_map("house")
    with pytest.raises(NotFound):
        found_map(map_store)
    assert map_store.maps() == []
    put_map(map_store, house(owner="bob"))
    assert found_map(map_store).owner == "bob"


CALLS_BY_ID: list[Callable[[MapStore, str], object]] = [
    found_map,
    lambda store, map_id: store.map_head(map_id),
    lambda store, map_id: store.remove_map(map_id),
    lambda store, map_id: store.versions(map_id),
    lambda store, map_id: found_map(store, map_id, "f" * 64),
    lambda store, map_id: store.change_map(map_id, readers=()),
]


@pytest.mark.parametrize("call", CALLS_BY_ID)
def test_unknown_maps_are_not_found(map_store: MapStore, call: Callable[[MapStore, str], object]) -> None:
    with pytest.raises(NotFound, match="nowhere"):
        call(map_store, "nowhere")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_ids_are_refused_by_all_calls(map_store: MapStore, name: str) -> None:
    for call in (*CALLS_BY_ID, lambda store, map_id: put_map(store, house(map_id))):
        with pytest.raises(InvalidInput):
            call(map_store, name)
    assert map_store.maps() == []


def test_a_version_depends_on_which_part_each_file_is() -> None:
    one, other = MapFile("a" * 64, 1), MapFile("b" * 64, 1)
    versions = {
        map_version(files)
        for files in (
            {"yaml": one, "image": other},
            {"yaml": other, "image": one},
            {"yaml": one, "image": one, "octomap": other},
            {"octomap": one},
        )
    }
    assert len(versions) == 4
    assert map_version({"image": other, "yaml": one}) == map_version({"yaml": one, "image": other})
