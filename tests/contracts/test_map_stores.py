"""The contract of every ``MapStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import MapStore
from storage.records import MapFile, Publication
from storage.versions import map_version
from tests.support.storage.records import NOT_NAMES, GivenMap, found_map, house, pgm, put_map

BT = b"# Octomap OcTree binary file\n..."


def said(author: str = "ann", **fields: object) -> Publication:
    return Publication("house", author, **({"created": 9.0} | fields))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "given",
    [house(readers=("bob", "*")), house(octomap=BT), house(image=None, octomap=BT), house(image=b"")],
    ids=["grid", "grid and octomap", "octomap", "empty file"],
)
def test_a_map_is_found_as_it_was_published(map_store: MapStore, given: GivenMap) -> None:
    head = put_map(map_store, given, message="first walk")
    assert found_map(map_store) == given
    assert head == map_store.map_head("house")
    assert (head.version, head.present.author, head.present.message) == (given.version, "ann", "first walk")
    assert {part: file.size for part, file in head.present.files.items()} == {
        part: len(data) for part, data in given.files.items()
    }


def test_only_the_files_that_are_asked_for_are_opened(map_store: MapStore) -> None:
    put_map(map_store, house(octomap=BT))
    with map_store.open_map("house", only=("octomap",)) as opened:
        assert {part: bytes(data) for part, data in opened.buffers.items()} == {"octomap": BT}
        assert opened.paths["octomap"].read_bytes() == BT
        with pytest.raises(NotFound, match="image"):
            opened.buffer("image")


def test_files_are_read_to_their_end_though_the_map_is_removed_meanwhile(map_store: MapStore) -> None:
    put_map(map_store, house())
    with map_store.open_map("house") as opened:
        map_store.remove_map("house")
        assert bytes(opened.buffer("image")) == pgm()


@pytest.mark.parametrize("parts", [(), ("yaml",), ("image",), ("yaml", "octomap")])
def test_what_lacks_a_file_is_no_map(map_store: MapStore, parts: tuple[str, ...]) -> None:
    with map_store.stage() as upload:
        for part in parts:
            upload.add(part, [b"x"])
        with pytest.raises(InvalidInput, match="a yaml with its image"):
            map_store.publish(upload, said())
    assert map_store.maps() == []


def test_a_file_comes_once_and_has_a_known_name(map_store: MapStore) -> None:
    with map_store.stage() as upload:
        upload.add("yaml", [b"a", b"b"])
        for part in ("yaml", "../yaml", "readme"):
            with pytest.raises(InvalidInput, match="one each of"):
                upload.add(part, [b"x"])
        assert bytes(upload.buffer("yaml")) == b"ab"


def test_the_last_version_is_the_present_one(map_store: MapStore) -> None:
    first, second = house(image=pgm(value=0)), house(image=pgm(value=254))
    assert first.version != second.version
    for record in (first, second, first):
        put_map(map_store, record)
        assert found_map(map_store) == record


def test_publishing_what_is_present_changes_but_what_is_said_of_it(map_store: MapStore) -> None:
    head = put_map(map_store, house(), message="first walk")
    again = put_map(map_store, house(created=8.0, description="hall"), message="once more")
    assert (again.present, again.description) == (head.present, "hall")
    assert map_store.versions("house") == [head.present]


def test_readers_change_without_a_new_version(map_store: MapStore) -> None:
    put_map(map_store, house(readers=("bob",)))
    put_map(map_store, house(readers=()))
    assert found_map(map_store).readers == ()


def test_heads_come_sorted_by_id(map_store: MapStore) -> None:
    for map_id in ("depot", "house", "Attic"):
        put_map(map_store, house(map_id))
    assert map_store.maps() == [map_store.map_head(map_id) for map_id in ("Attic", "depot", "house")]


def test_only_what_a_user_may_read_is_listed_for_that_user(map_store: MapStore) -> None:
    for map_id, owner, readers in (("a", "ann", ()), ("b", "ann", ("bob",)), ("c", "ann", ("*",)), ("d", "bob", ())):
        put_map(map_store, house(map_id, owner=owner, readers=readers))
    seen = {user: [head.id for head in map_store.maps(user)] for user in ("ann", "bob", "carl")}
    assert seen == {"ann": ["a", "b", "c"], "bob": ["b", "c", "d"], "carl": ["c"]}
    assert [head.id for head in map_store.maps("bob", after="b", limit=1)] == ["c"]


def test_every_version_is_kept_and_found_newest_first(map_store: MapStore) -> None:
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


def test_a_version_that_is_restored_is_the_present_one_and_told_as_such(map_store: MapStore) -> None:
    one, two = house(image=pgm(value=1), created=1.0), house(image=pgm(value=2), created=2.0)
    for given in (one, two):
        put_map(map_store, given)
    head = map_store.roll_back(one.version, said("bob", owner="ann", message="the door is closed"))
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
    assert map_store.roll_back(one.version, said("ann")) == head  # it is current already


def test_what_a_map_never_was_cannot_be_restored(map_store: MapStore) -> None:
    with pytest.raises(NotFound):
        map_store.roll_back("f" * 64, said())
    put_map(map_store, house())
    with pytest.raises(NotFound, match="version of map"):
        map_store.roll_back("f" * 64, said())
    with pytest.raises(Conflict):
        map_store.roll_back(house().version, said("bob"))


def test_who_expects_another_version_is_refused(map_store: MapStore) -> None:
    one, two, three = (house(image=pgm(value=value)) for value in (1, 2, 3))
    with pytest.raises(Conflict, match="does not exist"):
        put_map(map_store, one, if_match=two.version)
    put_map(map_store, one)
    put_map(map_store, two, if_match=one.version)
    with pytest.raises(Conflict, match=f"at version {two.version}, not at version {one.version}"):
        put_map(map_store, three, if_match=one.version)
    with pytest.raises(Conflict):
        map_store.roll_back(one.version, said(if_match=one.version))
    assert found_map(map_store).version == two.version


def test_of_many_who_publish_at_once_none_is_lost(map_store: MapStore) -> None:
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


def test_of_many_who_expect_the_same_version_one_publishes(map_store: MapStore) -> None:
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


def test_a_map_that_was_removed_comes_back_without_its_old_versions(map_store: MapStore) -> None:
    put_map(map_store, house(image=pgm(value=1)))
    map_store.remove_map("house")
    put_map(map_store, house(image=pgm(value=2)))
    assert [one.version for one in map_store.versions("house")] == [house(image=pgm(value=2)).version]


def test_what_is_said_of_a_map_changes_and_its_files_do_not(map_store: MapStore) -> None:
    put_map(map_store, house(readers=("bob",)))
    changed = map_store.change_map("house", description="the ground floor")
    assert (changed.readers, changed.description) == (("bob",), "the ground floor")
    assert changed == map_store.map_head("house")
    map_store.change_map("house", readers=())
    assert found_map(map_store) == house(description="the ground floor")
    assert found_map(map_store, version=house().version).description == "the ground floor"


@pytest.mark.parametrize("text", ["'; DROP TABLE maps; --", '"}{', "../../etc", "\0\u202e", "ä" * 256])
def test_texts_are_texts(map_store: MapStore, text: str) -> None:
    put_map(map_store, house(description=text), message=text)
    assert map_store.map_head("house").description == text
    assert map_store.versions("house")[0].message == text


def test_a_map_does_not_change_hands(map_store: MapStore) -> None:
    put_map(map_store, house(owner="ann"))
    with pytest.raises(Conflict, match="house"):
        put_map(map_store, house(owner="bob"))
    assert found_map(map_store).owner == "ann"


def test_one_of_many_who_take_an_id_at_once_gets_it(map_store: MapStore) -> None:
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


def test_a_removed_map_is_gone_and_its_id_free(map_store: MapStore) -> None:
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
def test_what_is_not_there_is_not_found(map_store: MapStore, call: Callable[[MapStore, str], object]) -> None:
    with pytest.raises(NotFound, match="nowhere"):
        call(map_store, "nowhere")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_ids_that_are_no_names_are_refused_wherever_they_are_given(map_store: MapStore, name: str) -> None:
    for call in (*CALLS_BY_ID, lambda store, map_id: put_map(store, house(map_id))):
        with pytest.raises(InvalidInput):
            call(map_store, name)
    assert map_store.maps() == []


def test_the_border_between_the_files_counts_for_the_version() -> None:
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
