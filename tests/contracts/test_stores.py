"""The contract of every ``Store``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import Store
from storage.records import LONGEST_HOLDER, CloneLogChange, Lease, Limits, RobotRecord
from storage.sharing_records import ProvidedIdentity, Share, TokenScope
from tests.support.storage.records import NOT_NAMES, clone, plan, robot, token, user


def test_a_user_is_returned_as_stored(store: Store) -> None:
    store.add_user(user("ann", role="admin"))
    assert store.user("ann") == user("ann", role="admin")


def test_own_limits_of_a_user_are_stored_changed_and_removed(store: Store) -> None:
    store.add_user(user("ann", limits=Limits(containers=0, cores=0.5)))
    assert store.user("ann").limits == store.users()[0].limits == Limits(containers=0, cores=0.5)
    store.change_user(user("ann", limits=Limits(maps=3, stored_bytes=1 << 40, versions_per_map=0)))
    assert store.user("ann").limits == Limits(maps=3, stored_bytes=1 << 40, versions_per_map=0)
    store.change_user(user("ann", limits=Limits(maps=3)))
    assert store.user("ann").limits == Limits(maps=3)
    store.change_user(user("ann"))
    assert store.user("ann") == user("ann")


def test_users_are_sorted_by_id(store: Store) -> None:
    for name in ("carl", "ann", "Bob"):
        store.add_user(user(name))
    assert [u.id for u in store.users()] == ["Bob", "ann", "carl"]


def test_a_taken_user_id_is_refused(store: Store) -> None:
    store.add_user(user("ann", password_hash="first"))
    with pytest.raises(Conflict, match="ann"):
        store.add_user(user("ann", password_hash="second"))
    assert store.user("ann").password_hash == "first"


def test_one_of_concurrent_registrations_gets_the_id(store: Store) -> None:
    start = Barrier(8)

    def register(number: int) -> bool:
        start.wait()
        try:
            store.add_user(user("ann", password_hash=str(number)))
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(8) as threads:
        won = list(threads.map(register, range(8)))
    assert won.count(True) == 1
    assert store.user("ann").password_hash == str(won.index(True))


def test_removing_a_user_removes_only_the_own_records(store: Store) -> None:
    for name, digest in (("ann", "a" * 64), ("bob", "b" * 64)):
        store.add_user(user(name))
        store.add_token(token(digest, user=name))
        store.put_robot(robot("tb1", user=name))
        store.save_clone(clone("tb1", user=name))
    store.remove_user("ann")
    for lost in (lambda: store.user("ann"), lambda: store.token("a" * 64), lambda: store.robot("ann", "tb1")):
        with pytest.raises(NotFound):
            lost()
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")
    assert store.token("b" * 64).user == "bob"
    assert (store.robots("ann"), store.robots("bob")) == ([], [robot("tb1", user="bob")])
    assert store.clone("bob", "tb1") == clone("tb1", user="bob")


LAB, OTHER = "https://login.example/realms/lab", "https://login.example/realms/other"


def test_a_user_is_found_by_the_identity(store: Store) -> None:
    ann, strange = ProvidedIdentity(LAB, "id of ann"), ProvidedIdentity(LAB, "日本/'\"%;?")
    for name, identity in (("ann", ann), ("bob", None), ("carl", strange), ("dora", ProvidedIdentity(OTHER, "7"))):
        store.add_user(user(name, identity=identity))
    assert store.user_with_identity(ann) == user("ann", identity=ann)
    assert store.user_with_identity(strange).id == "carl"
    for unknown in (ProvidedIdentity(OTHER, "id of ann"), ProvidedIdentity(LAB, "7"), ProvidedIdentity(LAB, "")):
        with pytest.raises(NotFound, match="identity"):
            store.user_with_identity(unknown)


def test_an_identity_that_was_bound_to_another_user_or_to_none_is_found_there(store: Store) -> None:
    before, now = ProvidedIdentity(LAB, "before"), ProvidedIdentity(LAB, "now")
    store.add_user(user("bob", identity=before))
    assert store.user_with_identity(before).id == "bob"
    store.change_user(user("bob", identity=now))
    assert store.user_with_identity(now).id == "bob"
    with pytest.raises(NotFound):
        store.user_with_identity(before)
    store.add_user(user("ann", identity=now))
    assert store.user_with_identity(now).id == "ann", "the first by id, if several have it"
    store.remove_user("ann")
    assert store.user_with_identity(now).id == "bob"
    store.change_user(user("bob"))
    with pytest.raises(NotFound):
        store.user_with_identity(now)
    store.add_user(user("ann"))
    with pytest.raises(NotFound):
        store.user_with_identity(now)


def test_a_token_needs_its_user(store: Store) -> None:
    with pytest.raises(NotFound, match="ann"):
        store.add_token(token(user="ann"))


def test_only_expired_tokens_are_removed(store: Store) -> None:
    store.add_user(user("ann"))
    for digest, expires in (("a", 10.0), ("b", 20.0), ("c", 30.0)):
        store.add_token(token(digest * 64, expires=expires))
    assert store.remove_tokens(expired_before=20.0) == 1
    assert store.token("b" * 64).expires == 20.0
    with pytest.raises(NotFound):
        store.token("a" * 64)


def test_tokens_of_a_user_are_listed_and_revoked(store: Store) -> None:
    for name, digest in (("ann", "b"), ("ann", "a"), ("bob", "c")):
        if name not in [known.id for known in store.users()]:
            store.add_user(user(name))
        store.add_token(token(digest * 64, user=name, created=7.0))
    assert store.tokens("ann") == [token("a" * 64, created=7.0), token("b" * 64, created=7.0)]
    store.remove_token("a" * 64)
    assert [one.hash for one in store.tokens("ann")] == ["b" * 64]
    assert [one.hash for one in store.tokens("bob")] == ["c" * 64]


def test_a_changed_user_keeps_tokens_with_the_same_password(store: Store) -> None:
    store.add_user(user("ann"))
    store.add_token(token("a" * 64))
    store.change_user(user("ann", role="admin"))
    assert store.user("ann").role == "admin"
    assert store.token("a" * 64).user == "ann"


def test_a_new_password_removes_only_the_users_other_tokens(store: Store) -> None:
    for name, digest in (("ann", "a"), ("bob", "c")):
        store.add_user(user(name))
        store.add_token(token(digest * 64, user=name))
    store.add_token(token("b" * 64))
    store.change_user(user("ann", password_hash="new"), keep_token="b" * 64)
    assert [one.hash for one in store.tokens("ann")] == ["b" * 64]
    store.change_user(user("ann", password_hash="newer"))
    assert store.tokens("ann") == []
    assert store.token("c" * 64).user == "bob"


def test_a_robot_is_returned_as_put_last(store: Store) -> None:
    parameters = {"DWAPlannerROS": {"max_vel_x": 0.26, "holonomic": False, "frames": ["odom", "map"], "none": None}}
    assert store.put_robot(robot("tb1", cores=0.25))
    assert not store.put_robot(robot("tb1", initial_pose=(1.5, -2.0, 3.1), parameters=parameters))
    assert store.robot("ann", "tb1") == robot("tb1", initial_pose=(1.5, -2.0, 3.1), parameters=parameters)


def test_a_robot_may_make_a_new_map(store: Store) -> None:
    assert store.put_robot(robot("tb1", map="new:office-2"))
    assert store.robot("ann", "tb1") == robot("tb1", map="new:office-2")
    for name in ("new:", "new:../office", "new:new:office"):
        with pytest.raises(InvalidInput, match="is not a valid name of a new map"):
            store.put_robot(robot("tb1", map=name))


def test_a_robot_changed_meanwhile_is_not_overwritten(store: Store) -> None:
    store.put_robot(robot("tb1", parameters={"a": 1}))
    seen = store.robot("ann", "tb1")
    store.put_robot(robot("tb1", cores=2.0))
    with pytest.raises(Conflict, match="meanwhile"):
        store.put_robot(robot("tb1", cores=3.0), instead_of=seen)
    store.put_robot(robot("tb1", cores=3.0), instead_of=store.robot("ann", "tb1"))
    assert store.robot("ann", "tb1").cores == 3.0
    store.remove_robot("ann", "tb1")
    with pytest.raises(Conflict, match="meanwhile"):
        store.put_robot(robot("tb1"), instead_of=seen)
    assert store.robots("ann") == []


def test_concurrent_changes_of_a_robot_lose_nothing(store: Store) -> None:
    store.put_robot(robot("tb1", properties={"count": 0}))

    def count_up(_: int) -> None:
        while True:
            seen = store.robot("ann", "tb1")
            try:
                store.put_robot(robot("tb1", properties={"count": seen.properties["count"] + 1}), instead_of=seen)
            except Conflict:
                continue
            return

    with ThreadPoolExecutor(3) as threads:
        list(threads.map(count_up, range(24)))
    assert store.robot("ann", "tb1").properties == {"count": 24}


@pytest.mark.parametrize("text", ["'; DROP TABLE robots; --", '" OR ""="', "%_?:x $$", "\0\u202e", "ä" * 256])
def test_texts_are_stored_unchanged(store: Store, text: str) -> None:
    kept = robot("tb1", description=text, properties={text: [text]}, parameters={text: {text: text}})
    store.put_robot(kept)
    store.put_urdf("ann", "tb1", text.encode())
    store.add_user(user("ann", password_hash=text))
    store.save_clone(clone("tb1", nodes={text: text.encode()}))
    assert store.robot("ann", "tb1") == kept
    assert store.robots("ann") == [kept]
    assert store.urdf("ann", "tb1") == text.encode()
    assert store.user("ann").password_hash == text
    assert store.clone("ann", "tb1") == clone("tb1", nodes={text: text.encode()})


def test_stored_records_do_not_share_objects_with_the_caller(store: Store) -> None:
    parameters = {"a": [1]}
    store.put_robot(robot("tb1", parameters=parameters))
    parameters["a"].append(2)
    store.robot("ann", "tb1").parameters["a"].append(3)
    assert store.robot("ann", "tb1").parameters == {"a": [1]}


@pytest.mark.parametrize("value", [object(), 1 << 70, "\ud800"])
def test_parameters_that_cannot_be_stored_are_refused(store: Store, value: object) -> None:
    store.put_robot(robot("tb1"))
    with pytest.raises(InvalidInput, match="cannot store"):
        store.put_robot(robot("tb1", parameters={"x": value}))
    assert store.robot("ann", "tb1") == robot("tb1")


def test_two_users_may_have_robots_of_the_same_id(store: Store) -> None:
    for name in ("bob", "ann"):
        store.put_robot(robot("tb1", user=name))
        store.put_robot(robot("tb0", user=name))
    assert [(r.user, r.id) for r in store.robots("ann")] == [("ann", "tb0"), ("ann", "tb1")]
    assert [(r.user, r.id) for r in store.robots("bob")] == [("bob", "tb0"), ("bob", "tb1")]
    store.remove_robot("ann", "tb1")
    assert store.robot("bob", "tb1").user == "bob"


def test_a_urdf_is_returned_unchanged_as_put_last(store: Store) -> None:
    store.put_robot(robot("tb1"))
    assert store.put_urdf("ann", "tb1", b"<robot/>")
    last = bytes(range(256)) * 4096
    assert not store.put_urdf("ann", "tb1", last)
    assert store.urdf("ann", "tb1") == last
    store.put_robot(robot("tb1", cores=0.25))
    assert store.urdf("ann", "tb1") == last
    store.remove_urdf("ann", "tb1")
    for gone in (lambda: store.urdf("ann", "tb1"), lambda: store.remove_urdf("ann", "tb1")):
        with pytest.raises(NotFound, match="URDF of robot 'tb1'"):
            gone()
    assert store.robot("ann", "tb1") == robot("tb1", cores=0.25)


def test_a_urdf_is_removed_with_its_robot_or_user(store: Store) -> None:
    with pytest.raises(NotFound, match="robot 'tb1'"):
        store.put_urdf("ann", "tb1", b"<robot/>")
    for name in ("ann", "bob"):
        store.add_user(user(name))
        for robot_id in ("tb1", "tb2"):
            store.put_robot(robot(robot_id, user=name))
            store.put_urdf(name, robot_id, f"<robot name='{name}'/>".encode())
    store.remove_robot("ann", "tb1")
    store.put_robot(robot("tb1"))
    store.remove_user("bob")
    store.put_robot(robot("tb1", user="bob"))
    for name in ("ann", "bob"):
        with pytest.raises(NotFound):
            store.urdf(name, "tb1")
    assert store.urdf("ann", "tb2") == b"<robot name='ann'/>"


def test_removing_a_robot_removes_its_checkpoint(store: Store) -> None:
    store.put_robot(robot("tb1"))
    store.save_clone(clone("tb1"))
    store.remove_robot("ann", "tb1")
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")


def test_a_plan_is_returned_as_stored(store: Store) -> None:
    kept = plan("p1", robot="tb1", cost=float("inf"))
    store.add_plan(kept)
    assert store.plan("p1") == kept


def test_adding_a_plan_twice_changes_nothing(store: Store) -> None:
    store.add_plan(plan("p1", cost=1.0))
    store.add_plan(plan("p1", cost=2.0))
    assert [p.cost for p in store.plans("house")] == [1.0]


def test_plans_are_listed_without_their_poses(store: Store) -> None:
    store.add_plan(plan("p1"))
    assert store.plans("house") == [plan("p1", poses=b"")]


def test_a_removed_plan_is_not_found(store: Store) -> None:
    store.add_plan(plan("p1"))
    store.remove_plan("p1")
    assert store.plans("house") == []
    with pytest.raises(NotFound):
        store.remove_plan("p1")


def test_plans_of_a_map_are_listed_newest_first(store: Store) -> None:
    for plan_id, created in (("a", 1.0), ("b", 3.0), ("c", 2.0), ("d", 3.0)):
        store.add_plan(plan(plan_id, created=created))
    store.add_plan(plan("other", map="depot", created=9.0))
    assert [p.id for p in store.plans("house")] == ["d", "b", "c", "a"]
    assert [p.id for p in store.plans("house", limit=2)] == ["d", "b"]
    assert store.plans("house", limit=0) == []
    assert store.plans("nowhere") == []


def test_the_last_checkpoint_is_kept(store: Store) -> None:
    store.save_clone(clone("tb1", saved=1.0))
    store.save_clone(clone("tb1", nodes={"amcl": b"new"}, saved=2.0))
    assert store.clone("ann", "tb1") == clone("tb1", nodes={"amcl": b"new"}, saved=2.0)


def test_a_checkpoint_may_be_removed_twice(store: Store) -> None:
    store.save_clone(clone("tb1"))
    store.remove_clone("ann", "tb1")
    store.remove_clone("ann", "tb1")
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")


def test_a_log_is_stored_with_a_checkpoint_and_removed_with_it(store: Store) -> None:
    assert store.clone_log("ann", "tb1", "new") == []
    store.save_clone(clone("tb1"), CloneLogChange("new", {2: b"two", 0: b"", 1: bytes(70_000)}))
    store.save_clone(clone("tb1", saved=8.0), CloneLogChange("new", {10: b"ten", 2: b"2"}, [1, 99]))
    store.save_clone(clone("tb1", user="bob"), CloneLogChange("new", {5: b"of bob"}))
    store.save_clone(clone("tb1", saved=9.0), CloneLogChange("other", {3: b"three"}))
    store.save_clone(clone("tb1", saved=9.5))
    assert store.clone("ann", "tb1") == clone("tb1", saved=9.5)
    assert store.clone_log("ann", "tb1", "new") == [(0, b""), (2, b"2"), (10, b"ten")]
    assert store.clone_log("ann", "tb1", "new", after=0, limit=1) == [(2, b"2")]
    assert store.clone_log("ann", "tb1", "new", limit=0) == []
    assert store.clone_log("ann", "tb1", "other") == [(3, b"three")]
    assert store.clone_logs("ann", "tb1") == ["new", "other"]
    store.remove_clone("ann", "tb1")
    assert store.clone_log("ann", "tb1", "new") == store.clone_log("ann", "tb1", "other") == []
    assert store.clone_logs("ann", "tb1") == []
    assert store.clone_log("bob", "tb1", "new") == [(5, b"of bob")]


def test_a_log_leaves_with_its_robot_and_its_user(store: Store) -> None:
    for name in ("ann", "bob"):
        store.add_user(user(name))
        store.put_robot(robot("tb1", user=name))
        store.save_clone(clone("tb1", user=name), CloneLogChange("new", {1: b"one"}))
    store.remove_robot("ann", "tb1")
    store.remove_user("bob")
    for name in ("ann", "bob"):
        store.save_clone(clone("tb1", user=name))
        assert store.clone_log(name, "tb1", "new") == []


CALLS_BY_NAME: list[Callable[[Store, str], object]] = [
    lambda store, name: store.user(name),
    lambda store, name: store.remove_user(name),
    lambda store, name: store.token(name),
    lambda store, name: store.robot("ann", name),
    lambda store, name: store.robot(name, "tb1"),
    lambda store, name: store.remove_robot("ann", name),
    lambda store, name: store.urdf("ann", name),
    lambda store, name: store.put_urdf(name, "tb1", b""),
    lambda store, name: store.remove_urdf("ann", name),
    lambda store, name: store.plan(name),
    lambda store, name: store.remove_plan(name),
    lambda store, name: store.remove_token(name),
    lambda store, name: store.change_user(user(name)),
    lambda store, name: store.clone("ann", name),
]


@pytest.mark.parametrize("call", CALLS_BY_NAME)
def test_unknown_names_are_not_found(store: Store, call: Callable[[Store, str], object]) -> None:
    with pytest.raises(NotFound, match=r"nobody|tb1"):
        call(store, "nobody")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_are_refused_by_all_calls(store: Store, name: str) -> None:
    storing: list[Callable[[Store, str], object]] = [
        lambda store, name: store.add_user(user(name)),
        lambda store, name: store.put_robot(robot(name)),
        lambda store, name: store.put_robot(robot(user=name)),
        lambda store, name: store.put_robot(robot(map=name)),
        lambda store, name: store.add_plan(plan(name)),
        lambda store, name: store.save_clone(clone(name)),
        lambda store, name: store.robots(name),
        lambda store, name: store.plans(name),
        lambda store, name: store.tokens(name),
    ]
    for call in (*CALLS_BY_NAME, *storing):
        with pytest.raises(InvalidInput):
            call(store, name)
    assert store.users() == []
    assert store.robots("ann") == []


NEVER_TAKEN = Lease("master")
FIRST = Lease("master", "a", 1)


# The contract of every ``LeaseStore``.


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


BOB = Share("bob", "drive", ("cmd_vel",), ("*",))
HALL = Share("group:hall", "look")


def shared(store: Store, owner: str, name: str, *shares: Share) -> RobotRecord:
    """Store a robot, and share it."""
    store.put_robot(robot(name, user=owner))
    return store.change_shares(store.robot(owner, name), shares)


def ids(records: list[RobotRecord]) -> list[str]:
    return [f"{record.user}:{record.id}" for record in records]


# The contract of every ``RobotStore`` for robots that are shared.


def test_shares_and_scopes_and_groups_are_returned_as_stored(store: Store) -> None:
    given = shared(store, "ann", "tb1", BOB, HALL)
    assert store.robot("ann", "tb1") == given
    assert store.robot("ann", "tb1").shares == (BOB, HALL)
    store.add_user(user("ann", groups=("hall", "night")))
    assert store.user("ann").groups == ("hall", "night")
    scoped = token("a" * 64, scope=TokenScope(("tb*",), "robot", ("scan",), ()), name="wall")
    store.add_token(scoped)
    assert store.token("a" * 64) == store.tokens("ann")[0] == scoped


def test_robots_are_listed_for_those_they_are_shared_with(store: Store) -> None:
    for owner, name in (("carl", "tb1"), ("ann", "tb2"), ("ann", "tb1"), ("Zoe", "tb9")):
        shared(store, owner, name, BOB)
    shared(store, "ann", "tb3", HALL)
    assert ids(store.robots_shared_with("bob")) == ["Zoe:tb9", "ann:tb1", "ann:tb2", "carl:tb1"]
    assert ids(store.robots_shared_with("group:hall")) == ["ann:tb3"]
    assert ids(store.robots_shared_with("bob", after=("ann", "tb1"), limit=1)) == ["ann:tb2"]
    assert store.robots_shared_with("bob", limit=0) == store.robots_shared_with("group:bob") == []


def test_a_robot_is_listed_no_more_once_it_is_not_shared(store: Store) -> None:
    record = shared(store, "ann", "tb1", BOB, HALL)
    store.change_shares(record, (HALL,))
    assert store.robots_shared_with("bob") == []
    assert ids(store.robots_shared_with("group:hall")) == ["ann:tb1"]
    store.put_robot(robot("tb1"))
    assert store.robots_shared_with("group:hall") == []


def test_shares_end_with_the_robot_and_with_its_user(store: Store) -> None:
    store.add_user(user("ann"))
    shared(store, "ann", "tb1", BOB)
    store.remove_robot("ann", "tb1")
    store.put_robot(robot("tb1"))
    assert store.robots_shared_with("bob") == []
    shared(store, "ann", "tb2", BOB)
    store.remove_user("ann")
    store.add_user(user("ann"))
    store.put_robot(robot("tb2"))
    assert store.robots_shared_with("bob") == []


def test_shares_of_a_robot_that_changed_meanwhile_are_not_changed(store: Store) -> None:
    before = shared(store, "ann", "tb1", BOB)
    store.change_shares(before, ())
    with pytest.raises(Conflict, match="tb1"):
        store.change_shares(before, (BOB, HALL))
    assert store.robot("ann", "tb1").shares == ()
    assert store.robots_shared_with("bob") == store.robots_shared_with("group:hall") == []
    store.remove_robot("ann", "tb1")
    with pytest.raises(Conflict):
        store.change_shares(before, ())
    with pytest.raises(NotFound):
        store.robot("ann", "tb1")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_of_users_and_groups_are_refused(store: Store, name: str) -> None:
    record = shared(store, "ann", "tb1")
    calls: list[Callable[[str], object]] = [
        store.robots_shared_with,
        lambda grantee: store.change_shares(record, (Share(grantee, "look"),)),
    ]
    for call in calls:
        for grantee in (name, f"group:{name}", f"group:group:{name}"):
            with pytest.raises(InvalidInput):
                call(grantee)
