"""Removal of users over all stores: a later user of the id has nothing of the former one, whatever was cut short."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from argon2 import PasswordHasher, profiles

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.resources import removal
from endpoints.resources.services import Services
from endpoints.sharing.shared_robots import is_author
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, NotAuthenticated, NotFound
from ppaas.tasks.records import Task
from storage.ports import MapStore, Store
from storage.recordings import RecordingsFolder
from storage.records import Limits, MapTask
from storage.sharing_records import Share, TokenScope
from storage.webhooks.records import Webhook
from tests.servers.jars import OTHER_HADOOPS
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.storage.records import building, clone, house, plan, put_map, robot

pytestmark = pytest.mark.parametrize(
    ("store", "map_store"),
    [
        ("memory:", "memory:"),
        ("sqlite://{folder}/store.db", "file://{folder}/maps"),
        pytest.param("cassandra", "hdfs", marks=pytest.mark.servers),
        *(pytest.param("memory:", f"hdfs {version}", marks=pytest.mark.servers) for version in OTHER_HADOOPS),
    ],
    indirect=True,
)

PASSWORD = "correct horse"
NOW = 2e9


class Killed(Exception):
    """Stands for the death of the process at a step."""


@pytest.fixture
def passwords() -> Iterator[Passwords]:
    hashing = Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1, waiting=8)
    yield hashing
    hashing.close()


@pytest.fixture
def services(store: Store, map_store: MapStore, passwords: Passwords, tmp_path: Path) -> Services:
    clock = ManualClock(NOW)
    accounts = Accounts(store, clock, passwords=passwords)
    folder = RecordingsFolder(tmp_path / "recordings")
    return Services(store, map_store, accounts, FakeCloud(), recordings=folder)


async def give_all(services: Services) -> str:
    """Give the user ``ann`` all that can name a user; return a token of hers."""
    store = services.store
    for name in ("ann", "bob"):
        await services.accounts.register(name, PASSWORD)
    await services.accounts.change("ann", limits={"robots": 99}, regroup=lambda _: ("crew", "alone"))
    await services.accounts.change("bob", regroup=lambda _: ("crew",))
    put_map(services.map_store, house(owner="bob"), readers=("ann", "carl"))
    store.put_building(building(owner="bob", readers=("ann", "carl")))
    store.put_building(building(owner="ann"))
    shares = tuple(Share(to, "drive") for to in ("ann", "carl", "group:crew", "group:alone"))
    store.put_robot(robot("tb9", user="bob", shares=shares))
    store.put_robot(robot("tb1", user="ann"))
    store.put_urdf("ann", "tb1", b"<robot/>")
    store.save_clone(clone("tb1", user="ann"))
    store.put_task(MapTask("ann", "house", Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))))
    store.put_webhook(Webhook(user="ann", id="wh-1", url="https://example.org", events=("*",)))
    store.add_plan(plan("p1", user="ann", map="house", created=NOW))
    recorded = services.recordings.of_robot("ann", "tb1")  # type: ignore[union-attr]
    recorded.mkdir(parents=True)
    (recorded / "x.mcap").write_bytes(b"x")
    await services.accounts.issue_scoped("ann", TokenScope(("*",), "robot"), 1e6)
    return await services.accounts.login("ann", PASSWORD)


def left(services: Services) -> list[str]:
    """Return what the user ``ann`` has."""
    store, ann = services.store, services.store.user("ann")
    found = {
        "maps": [head.id for head in services.map_store.maps("ann")],
        "shared robots": [one.id for to in ("ann", "group:alone") for one in store.robots_shared_with(to)],
        "robots": store.robots("ann"),
        "tokens": store.tokens("ann"),
        "tasks": store.tasks("ann", "house"),
        "buildings": store.buildings("ann"),
        "buildings to read": [one.id for one in store.buildings("bob") if one.readable_by("ann")],
        "webhooks": store.webhooks("ann"),
        "groups": ann.groups,
        "limits": ann.limits != Limits(),
        "recordings": services.recordings.of_robot("ann", "tb1").exists(),  # type: ignore[union-attr]
        "plans": is_author(ann, store.plan("p1")),
    }
    for name, read in (("urdf", store.urdf), ("clone", store.clone)):
        with suppress(NotFound):
            found[name] = read("ann", "tb1")
    return [name for name, value in found.items() if value]


def others_keep_theirs(services: Services) -> None:
    assert services.map_store.map_head("house").readers == ("carl",)
    assert services.store.building("bob", "hq") == building(owner="bob", readers=("carl",))
    assert [share.to for share in services.store.robot("bob", "tb9").shares] == ["carl", "group:crew"]
    assert services.store.user("bob").groups == ("crew",)
    assert services.store.plan("p1").user == "ann", "what was planned stays, also with its author's name"


async def create_again(services: Services) -> None:
    await removal.make_user_free(services, "ann")
    services.accounts._clock.advance(60.0)  # type: ignore[attr-defined]
    await services.accounts.register("ann", "another password")


async def test_a_later_user_of_the_same_id_has_nothing_of_the_former_one(services: Services) -> None:
    token = await give_all(services)
    assert len(left(services)) == 14, "all of it is there before"
    await removal.remove_user(services, "ann")
    with pytest.raises(NotFound):
        services.store.user("ann")
    await create_again(services)
    assert left(services) == []
    others_keep_theirs(services)
    with pytest.raises(NotAuthenticated):
        await services.accounts.authenticate(token)


STEPS: list[tuple[str, Callable[[Services], object], str]] = [
    ("places", lambda services: services.cloud.users, "end_places"),
    ("readers", lambda services: services.map_store, "change_map"),
    ("shares", lambda services: services.store, "change_shares"),
    ("recordings", lambda services: services.recordings, "remove_user"),
    ("user", lambda services: services.store, "remove_user"),
    ("limits", lambda services: services.cloud, "set_limits"),
]


@pytest.mark.parametrize("finisher", ["creation", "removal", "job"])
@pytest.mark.parametrize(("place", "name"), [step[1:] for step in STEPS], ids=[step[0] for step in STEPS])
async def test_a_removal_that_is_cut_short_is_finished_before_the_id_is_given_again(
    services: Services,
    place: Callable[[Services], object],
    name: str,
    finisher: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    token = await give_all(services)

    def killed(*_: object, **__: object) -> None:
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(place(services), name, killed)
        with pytest.raises(Killed):
            await removal.remove_user(services, "ann")
    with pytest.raises(NotAuthenticated):
        await services.accounts.authenticate(token)
    with pytest.raises(NotAuthenticated):
        await services.accounts.login("ann", PASSWORD)
    is_gone = name == "set_limits"
    if not is_gone:
        with pytest.raises(Conflict):
            await services.accounts.register("ann", "another password")
        if finisher == "removal":
            await removal.remove_user(services, "ann")
        elif finisher == "job":
            await removal.RemovedUsers(services).look()
    await create_again(services)
    assert left(services) == []
    others_keep_theirs(services)


async def test_what_requests_on_their_way_stored_for_a_user_who_was_gone_is_not_a_later_ones(
    services: Services,
) -> None:
    await services.accounts.register("ann", PASSWORD)
    await removal.remove_user(services, "ann")
    services.store.put_task(MapTask("ann", "house", Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))))
    services.store.put_robot(robot("tb1", user="ann"))
    services.store.put_webhook(Webhook(user="ann", id="wh-1", url="https://example.org", events=("*",)))
    services.store.put_building(building())
    await removal.make_user_free(services, "ann")
    await services.accounts.register("ann", PASSWORD)
    assert services.store.tasks("ann", "house") == [] == services.store.robots("ann")
    assert services.store.webhooks("ann") == [] == services.store.buildings("ann")


async def test_a_user_who_exists_loses_nothing_when_the_id_is_asked_for_again(services: Services) -> None:
    await give_all(services)
    before = left(services)
    await removal.make_user_free(services, "ann")
    assert left(services) == before
