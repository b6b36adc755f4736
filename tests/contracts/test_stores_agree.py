"""Whatever is done to them in whatever order, every store answers as the one of dictionaries does."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule

from ppaas.errors import PPaaSError
from storage.files import FileMapStore
from storage.memory import MemoryMapStore, MemoryStore
from storage.sqlite import SqliteStore
from tests.support.records import clone, house, pgm, plan, robot, token, user

names = st.sampled_from(["ann", "bob", "x.y-z_1", "../etc"])
hashes = st.sampled_from(["a" * 64, "b" * 64])
numbers = st.floats(allow_nan=False, allow_infinity=False)
values = st.recursive(
    st.none() | st.booleans() | numbers | st.integers(-(2**63), 2**63) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


def outcome(call: Callable[[Any], Any], store: Any) -> Any:
    """Return what a call returns, or the kind and text of what it raises."""
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

    @rule(name=names, role=st.sampled_from(["admin", "user"]))
    def add_user(self, name: str, role: str) -> None:
        self.same(lambda store: store.add_user(user(name, role=role)))

    @rule(name=names)
    def remove_user(self, name: str) -> None:
        self.same(lambda store: store.remove_user(name))

    @rule(digest=hashes, name=names, expires=numbers)
    def add_token(self, digest: str, name: str, expires: float) -> None:
        self.same(lambda store: store.add_token(token(digest, user=name, expires=expires)))

    @rule(now=numbers)
    def remove_tokens(self, now: float) -> None:
        self.same(lambda store: store.remove_tokens(expired_before=now))

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

    @rule(name=names, role=st.sampled_from(["admin", "user"]), password=hashes, keep=st.none() | hashes)
    def change_user(self, name: str, role: str, password: str, keep: str | None) -> None:
        changed = user(name, role=role, password_hash=password)
        self.same(lambda store: store.change_user(changed, keep_token=keep))

    @rule(digest=hashes)
    def remove_token(self, digest: str) -> None:
        self.same(lambda store: store.remove_token(digest))

    @rule(name=names)
    def remove_plan(self, name: str) -> None:
        self.same(lambda store: store.remove_plan(name))

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
        self.same(lambda store: store.token(digest))
        self.same(lambda store: store.robots(owner, after=name, limit=limit))
        self.same(lambda store: store.users(after=name, limit=limit))
        self.same(lambda store: store.tokens(name, after=digest, limit=limit))
        self.same(lambda store: store.robot(owner, name))
        self.same(lambda store: store.urdf(owner, name))
        self.same(lambda store: store.plan(name))
        self.same(lambda store: store.plans(name, before=before, limit=limit))
        self.same(lambda store: store.clone(owner, name))


class MapStoresAgree(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.stores = (MemoryMapStore(), FileMapStore(Path(self.folder.name)))

    def same(self, call: Callable[[Any], Any]) -> None:
        expected, other = (outcome(call, store) for store in self.stores)
        assert other == expected

    def teardown(self) -> None:
        self.folder.cleanup()

    @rule(name=names, owner=names, shade=st.integers(0, 2), readers=st.lists(names, max_size=2), created=numbers)
    def put_map(self, name: str, owner: str, shade: int, readers: list[str], created: float) -> None:
        record = house(name, owner, pgm(value=shade), readers=readers, created=created)
        self.same(lambda store: store.put_map(record))

    @rule(name=names, readers=st.none() | st.lists(names, max_size=2).map(tuple), text=st.none() | st.text(max_size=3))
    def change_map(self, name: str, readers: tuple[str, ...] | None, text: str | None) -> None:
        self.same(lambda store: store.change_map(name, readers=readers, description=text))

    @rule(name=names)
    def remove_map(self, name: str) -> None:
        self.same(lambda store: store.remove_map(name))

    @rule(name=names, reader=st.none() | names, limit=st.none() | st.integers(0, 3), shade=st.integers(0, 2))
    def look(self, name: str, reader: str | None, limit: int | None, shade: int) -> None:
        self.same(lambda store: store.maps(reader, after=name, limit=limit))
        self.same(lambda store: store.map(name))
        self.same(lambda store: store.map(name, house(image=pgm(value=shade)).version))
        self.same(lambda store: store.versions(name, limit=limit))
        self.same(lambda store: store.map_head(name))


# Every commit of the file stores is synced, which a loaded disk may take long over.
TestStoresAgree = StoresAgree.TestCase
TestStoresAgree.settings = settings(max_examples=20, stateful_step_count=30, deadline=None)
TestMapStoresAgree = MapStoresAgree.TestCase
TestMapStoresAgree.settings = settings(max_examples=20, stateful_step_count=20, deadline=None)
