"""After any sequence of operations, all stores give the same answers as the one in memory."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule
from msgspec.structs import replace

from ppaas.errors import PPaaSError
from ppaas.people.settings import PeopleSettings
from ppaas.tasks.records import Task
from storage.files.store import FileMapStore
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.people import HOUR, MapPeople, PeopleCount
from storage.ports import MapStore
from storage.records import MapRecord, MapTask, MapVersionRecord, Publication
from storage.sharing_records import ProvidedIdentity, Share
from storage.sqlite.store import SqliteStore
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.reference.plans.map_store import PlainMaps
from tests.support.budget import examples
from tests.support.storage.records import (
    GivenMap,
    building,
    clone,
    found_map,
    house,
    pgm,
    plan,
    put_map,
    robot,
    token,
    user,
)

names = st.sampled_from(["ann", "bob", "x.y-z_1", "../etc"])
grantees = names | names.map("group:{}".format)
IDENTITY = ProvidedIdentity("https://login.example", "ann")
identities = st.sampled_from([None, IDENTITY, ProvidedIdentity("https://login.example", "bob")])
hashes = st.sampled_from(["a" * 64, "b" * 64])
numbers = st.floats(allow_nan=False, allow_infinity=False)
hours = st.integers(-1, 3).map(lambda number: HOUR * number)
zones = st.sampled_from(["", "door"])
shades = st.integers(0, 2)
expected = st.none() | shades
values = st.recursive(
    st.none() | st.booleans() | numbers | st.integers(-(2**63), 2**63) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


def outcome(call: Callable[[Any], Any], store: Any) -> Any:
    """Return the result of a call, or the type and message of its error."""
    try:
        return call(store)
    except PPaaSError as error:
        return type(error), str(error)


class StoresAgree(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.stores = (MemoryStore(), SqliteStore(Path(self.folder.name) / "store.db"))

    def same(self, call: Callable[[Any], Any]) -> None:
        expected, *others = (outcome(call, store) for store in self.stores)
        for other in others:
            assert other == expected

    def teardown(self) -> None:
        for store in self.stores:
            store.close()
        self.folder.cleanup()

    @rule(name=names, role=st.sampled_from(["admin", "user"]), identity=identities)
    def add_user(self, name: str, role: str, identity: ProvidedIdentity | None) -> None:
        self.same(lambda store: store.add_user(user(name, role=role, identity=identity)))

    @rule(name=names)
    def remove_user(self, name: str) -> None:
        self.same(lambda store: store.remove_user(name))

    @rule(digest=hashes, name=names, expires=numbers)
    def add_token(self, digest: str, name: str, expires: float) -> None:
        self.same(lambda store: store.add_token(token(digest, user=name, expires=expires)))

    @rule(now=numbers)
    def remove_tokens(self, now: float) -> None:
        self.same(lambda store: store.remove_tokens(expired_before=now))

    @rule(name=names, owner=names, grantees=st.lists(grantees, max_size=2))
    def change_shares(self, name: str, owner: str, grantees: list[str]) -> None:
        shares = tuple(Share(grantee, "look") for grantee in grantees)
        self.same(lambda store: store.change_shares(store.robot(owner, name), shares))
        for grantee in ("ann", "group:bob"):
            self.same(lambda store, grantee=grantee: store.robots_shared_with(grantee, after=("ann", "ann"), limit=3))

    @rule(name=names, owner=names, pose=st.tuples(numbers, numbers, numbers), value=values)
    def put_robot(self, name: str, owner: str, pose: tuple[float, float, float], value: Any) -> None:
        self.same(lambda store: store.put_robot(robot(name, user=owner, initial_pose=pose, parameters={"p": value})))

    @rule(name=names, owner=names)
    def remove_robot(self, name: str, owner: str) -> None:
        self.same(lambda store: store.remove_robot(owner, name))

    @rule(name=names, owner=names, urdf=st.none() | st.binary(max_size=8))
    def change_urdf(self, name: str, owner: str, urdf: bytes | None) -> None:
        if urdf is None:
            self.same(lambda store: store.remove_urdf(owner, name))
        else:
            self.same(lambda store: store.put_urdf(owner, name, urdf))

    @rule(name=names, map_id=names, created=numbers)
    def add_plan(self, name: str, map_id: str, created: float) -> None:
        self.same(lambda store: store.add_plan(plan(name, map=map_id, created=created)))

    @rule(name=names, owner=names, state=st.binary(max_size=8))
    def save_clone(self, name: str, owner: str, state: bytes) -> None:
        self.same(lambda store: store.save_clone(clone(name, user=owner, nodes={"amcl": state})))

    @rule(name=names, owner=names)
    def remove_clone(self, name: str, owner: str) -> None:
        self.same(lambda store: store.remove_clone(owner, name))

    @rule(name=names, identity=identities, password=hashes, keep=st.none() | hashes)
    def change_user(self, name: str, identity: ProvidedIdentity | None, password: str, keep: str | None) -> None:
        changed = user(name, identity=identity, password_hash=password)
        self.same(lambda store: store.change_user(changed, keep_token=keep))

    @rule(digest=hashes)
    def remove_token(self, digest: str) -> None:
        self.same(lambda store: store.remove_token(digest))

    @rule(name=names)
    def remove_plan(self, name: str) -> None:
        self.same(lambda store: store.remove_plan(name))

    @rule(name=names, owner=names, history=st.booleans())
    def put_people_settings(self, name: str, owner: str, history: bool) -> None:
        record = MapPeople(owner, name, PeopleSettings(history=history))
        self.same(
            lambda store: store.put_people_settings(record, instead_of=MapPeople(owner, name) if history else None)
        )

    @rule(name=names, owner=names, hour=hours, zone=zones, people=st.integers(0, 5))
    def add_people_counts(self, name: str, owner: str, hour: int, zone: str, people: int) -> None:
        self.same(lambda store: store.add_people_counts([PeopleCount(owner, name, hour, zone, people)]))

    @rule(name=names, owner=names, before=st.none() | hours)
    def remove_people_counts(self, name: str, owner: str, before: int | None) -> None:
        self.same(lambda store: store.remove_people_counts(owner, name, before=before))

    @rule(name=names)
    def remove_people(self, name: str) -> None:
        self.same(lambda store: store.remove_people(name))

    @rule(name=names, owner=names, map_id=names, priority=st.integers(0, 2), first=st.booleans())
    def put_task(self, name: str, owner: str, map_id: str, priority: int, first: bool) -> None:
        task = Task(id=name, kind="go_to", places=((0.0, 0.0, 0.0),))
        changed = MapTask(owner, map_id, replace(task, priority=priority))
        before = None if first else MapTask(owner, map_id, task)
        self.same(lambda store: store.put_task(changed, instead_of=before))

    @rule(name=names, owner=names, map_id=names, whole=st.booleans())
    def remove_tasks(self, name: str, owner: str, map_id: str, whole: bool) -> None:
        if whole:
            self.same(lambda store: store.remove_tasks(map_id))
        else:
            self.same(lambda store: store.remove_task(owner, map_id, name))

    @rule(name=names, owner=names, map_id=names, limit=st.none() | st.integers(0, 3))
    def look_for_tasks(self, name: str, owner: str, map_id: str, limit: int | None) -> None:
        self.same(lambda store: store.task(owner, map_id, name))
        self.same(lambda store: store.tasks(owner, map_id, after=name, limit=limit))
        self.same(lambda store: store.task_groups())

    @rule(name=names, owner=names, versions=st.integers(1, 3), first=st.booleans())
    def put_building(self, name: str, owner: str, versions: int, first: bool) -> None:
        before = None if first else building(name, owner, versions=versions)
        after = building(name, owner, versions=versions + (not first))
        self.same(lambda store: store.put_building(after, instead_of=before))

    @rule(name=names, owner=names, versions=st.none() | st.integers(1, 3))
    def remove_building(self, name: str, owner: str, versions: int | None) -> None:
        before = None if versions is None else building(name, owner, versions=versions)
        self.same(lambda store: store.remove_building(owner, name, instead_of=before))

    @rule(name=names, owner=names, limit=st.none() | st.integers(0, 3))
    def look_for_buildings(self, name: str, owner: str, limit: int | None) -> None:
        self.same(lambda store: store.building(owner, name))
        self.same(lambda store: store.buildings(owner, after=name, limit=limit))
        self.same(lambda store: store.building_users())

    @rule(name=names, owner=names, url=shades, first=st.booleans())
    def put_webhook(self, name: str, owner: str, url: int, first: bool) -> None:
        hook = Webhook(user=owner, id=name, url="0", events=("*",))
        before = None if first else hook
        self.same(lambda store: store.put_webhook(replace(hook, url=str(url)), instead_of=before))

    @rule(name=names, owner=names)
    def remove_webhook(self, name: str, owner: str) -> None:
        self.same(lambda store: store.remove_webhook(owner, name))

    @rule(name=names, owner=names, hook=names, attempts=shades, removed=st.booleans())
    def change_delivery(self, name: str, owner: str, hook: str, attempts: int, removed: bool) -> None:
        record = WebhookDelivery(user=owner, hook=hook, id=name, event="e", body=b"{}", created=0.0, attempts=attempts)
        if removed:
            self.same(lambda store: store.remove_delivery(owner, hook, name))
        else:
            self.same(lambda store: store.put_delivery(record))

    @rule(name=names, owner=names, hook=names, limit=st.none() | st.integers(0, 3))
    def look_for_webhooks(self, name: str, owner: str, hook: str, limit: int | None) -> None:
        self.same(lambda store: store.webhook(owner, hook))
        self.same(lambda store: store.webhooks(owner, after=name, limit=limit))
        self.same(lambda store: store.webhook_users())
        self.same(lambda store: store.delivery(owner, hook, name))
        self.same(lambda store: store.deliveries(owner, hook, after=name, limit=limit))

    @rule(name=names, owner=names, after=st.tuples(hours, zones), limit=st.none() | st.integers(0, 3))
    def count(self, name: str, owner: str, after: tuple[int, str], limit: int | None) -> None:
        self.same(lambda store: store.map_people(owner, name))
        self.same(lambda store: store.people_of_map(name))
        self.same(lambda store: store.people_maps())
        self.same(lambda store: store.people_counts(owner, name, after=after, limit=limit))

    @rule(
        name=names,
        owner=names,
        digest=hashes,
        limit=st.none() | st.integers(0, 3),
        before=st.none() | st.tuples(numbers, names),
    )
    def look(self, name: str, owner: str, digest: str, limit: int | None, before: tuple[float, str] | None) -> None:
        self.same(lambda store: store.users())
        self.same(lambda store: store.user(name))
        self.same(lambda store: store.user_with_identity(IDENTITY))
        self.same(lambda store: store.token(digest))
        self.same(lambda store: store.robots(owner, after=name, limit=limit))
        self.same(lambda store: store.users(after=name, limit=limit))
        self.same(lambda store: store.tokens(name, after=digest, limit=limit))
        self.same(lambda store: store.robot(owner, name))
        self.same(lambda store: store.urdf(owner, name))
        self.same(lambda store: store.plan(name))
        self.same(lambda store: store.plans(name, before=before, limit=limit))
        self.same(lambda store: store.clone(owner, name))


class StoreAdapter:
    """A map store with the interface of ``PlainMaps``."""

    def __init__(self, store: MapStore) -> None:
        self.store = store

    def put(self, given: GivenMap, if_match: str | None) -> dict[str, Any]:
        return head_fields(put_map(self.store, given, if_match=if_match))

    def roll_back(self, map_id: str, version: str, owner: str, created: float) -> dict[str, Any]:
        return head_fields(self.store.roll_back(version, Publication(map_id, owner, created)))

    def change(self, map_id: str, readers: tuple[str, ...] | None, description: str | None) -> dict[str, Any]:
        return head_fields(self.store.change_map(map_id, readers=readers, description=description))

    def remove(self, map_id: str) -> None:
        self.store.remove_map(map_id)

    def head(self, map_id: str) -> dict[str, Any]:
        return head_fields(self.store.map_head(map_id))

    def versions(self, map_id: str, limit: int | None) -> list[tuple[Any, ...]]:
        return [published(one) for one in self.store.versions(map_id, limit=limit)]

    def ids(self, reader: str | None, after: str, limit: int | None) -> list[str]:
        return [head.id for head in self.store.maps(reader, after=after, limit=limit)]

    def files(self, map_id: str) -> dict[str, bytes]:
        return found_map(self.store, map_id).files


def head_fields(record: MapRecord) -> dict[str, Any]:
    fields = {"owner": record.owner, "readers": record.readers, "description": record.description}
    return fields | {"present": published(record.present)}


def published(one: MapVersionRecord) -> tuple[Any, ...]:
    return one.version, one.created, one.author, one.restored


class MapStoresAgree(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        kept = FileMapStore(Path(self.folder.name)), MemoryMapStore()
        self.stores = (PlainMaps(), *map(StoreAdapter, kept))

    def same(self, call: Callable[[Any], Any]) -> None:
        expected, *others = (outcome(call, store) for store in self.stores)
        assert others == [expected] * 2

    def teardown(self) -> None:
        self.folder.cleanup()

    @rule(
        name=names, owner=names, shade=shades, readers=st.lists(names, max_size=2), created=numbers, expected=expected
    )
    def put(self, name: str, owner: str, shade: int, readers: list[str], created: float, expected: int | None) -> None:
        given = house(name, owner, pgm(value=shade), readers=tuple(readers), created=created)
        if_match = None if expected is None else house(image=pgm(value=expected)).version
        self.same(lambda store: store.put(given, if_match))

    @rule(name=names, owner=names, shade=shades, created=numbers)
    def roll_back(self, name: str, owner: str, shade: int, created: float) -> None:
        version = house(image=pgm(value=shade)).version
        self.same(lambda store: store.roll_back(name, version, owner, created))

    @rule(name=names, readers=st.none() | st.lists(names, max_size=2).map(tuple), text=st.none() | st.text(max_size=3))
    def change(self, name: str, readers: tuple[str, ...] | None, text: str | None) -> None:
        self.same(lambda store: store.change(name, readers, text))

    @rule(name=names)
    def remove(self, name: str) -> None:
        self.same(lambda store: store.remove(name))

    @rule(name=names, reader=st.none() | names, limit=st.none() | st.integers(0, 3))
    def look(self, name: str, reader: str | None, limit: int | None) -> None:
        self.same(lambda store: store.ids(reader, name, limit))
        self.same(lambda store: store.versions(name, limit))
        self.same(lambda store: store.head(name))
        self.same(lambda store: store.files(name))


# Every commit of the file stores is synced, which takes long on a busy disk.
TestStoresAgree = StoresAgree.TestCase
TestStoresAgree.settings = settings(max_examples=examples(20), stateful_step_count=30)
TestMapStoresAgree = MapStoresAgree.TestCase
TestMapStoresAgree.settings = settings(max_examples=examples(20), stateful_step_count=20)
