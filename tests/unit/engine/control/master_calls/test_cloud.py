"""Parts of the engine in the process of the master: their Protocols, maps in use, quotas of users, news."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_type_hints

import pytest

from engine.calls.interface import methods_of
from engine.control.master_calls.cloud import MapsInUse, UserQuotas
from engine.control.master_calls.control_plane import ControlPlane, MasterParts
from engine.control.news import News
from engine.control.views import UserUsage
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import MapVersion
from ppaas.errors import NotAuthenticated, QuotaExceeded
from storage.records import Limits, MapFile, MapRecord, MapVersionRecord
from storage.versions import OCTOMAP, YAML
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.master_cloud import MasterCloud


@pytest.fixture(params=[MasterCloud, lambda _: FakeCloud()], ids=["product", "fake"])
async def cloud(request: pytest.FixtureRequest, tmp_path: Path) -> ControlPlane:
    make: Callable[[Path], ControlPlane] = request.param
    return make(tmp_path)


@pytest.mark.parametrize(("name", "interface"), get_type_hints(MasterParts).items())
async def test_a_part_has_the_methods_of_its_protocol(cloud: ControlPlane, name: str, interface: type) -> None:
    part = getattr(cloud, name)
    methods = methods_of(interface)
    assert methods
    for method in methods:
        expected = inspect.signature(getattr(interface, method.attribute)).parameters
        found = inspect.signature(getattr(part, method.attribute)).parameters
        assert ["self", *found] == list(expected), method.name


def test_no_two_methods_have_one_name_on_the_wire() -> None:
    names = [method.name for part in get_type_hints(MasterParts).values() for method in methods_of(part)]
    assert len(names) == len(set(names)) > 30


class Driver:
    """Notes changes of maps."""

    def __init__(self) -> None:
        self.changes: list[tuple[Any, ...]] = []

    def map_changed(self, version: MapVersion, number: int, *, in_space: bool) -> None:
        self.changes.append((version, number, in_space))


class Groups:
    """Notes maps whose groups are ended."""

    def __init__(self) -> None:
        self.closed: list[str] = []

    async def close_map(self, map_id: str) -> None:
        self.closed.append(map_id)


def with_files(*names: str) -> MapRecord:
    """Return a map whose current version has files of these names only."""
    files = {name: MapFile("0", 1) for name in names}
    return MapRecord("house", "ann", MapVersionRecord(7, "v7", 1000.0, "ann", files=files))


@pytest.mark.parametrize(("names", "in_space"), [((YAML,), False), ((YAML, OCTOMAP), True)])
async def test_robots_move_to_a_version_with_a_grid(names: tuple[str, ...], in_space: bool) -> None:
    driver, head = Driver(), with_files(*names)
    await MapsInUse(driver, ()).changed(head)  # type: ignore[arg-type]
    assert driver.changes == [(MapVersion("house", "v7"), 7, in_space)]


async def test_robots_stay_on_the_version_before_one_without_a_grid() -> None:
    driver = Driver()
    await MapsInUse(driver, ()).changed(with_files(OCTOMAP))  # type: ignore[arg-type]
    assert driver.changes == []


async def test_groups_of_all_kinds_on_a_removed_map_are_ended() -> None:
    people, traffic = Groups(), Groups()
    await MapsInUse(Driver(), (people, traffic)).end_groups("house")  # type: ignore[arg-type]
    assert people.closed == traffic.closed == ["house"]


class QuotaDriver:
    """Notes what it is asked to do."""

    def __init__(self, quotas: Quotas) -> None:
        self.quotas = quotas
        self.did: list[tuple[Any, ...]] = []

    def set_limits(self, user: str, limits: Limits) -> None:
        self.did.append((user, limits))
        self.quotas.set_limits(user, limits)

    async def close_places(self, user: str, reason: Exception) -> None:
        self.did.append((user, reason))

    async def close_place(self, key: str, reason: Exception) -> None:
        self.did.append((key, reason))


@pytest.fixture
def driver() -> QuotaDriver:
    return QuotaDriver(Quotas(Quota(containers=1, cores=1.0, plans_per_minute=2000)))


@pytest.fixture
def users(driver: QuotaDriver) -> UserQuotas:
    return UserQuotas(driver, driver.quotas)  # type: ignore[arg-type]


async def test_limits_are_applied_once(users: UserQuotas, driver: QuotaDriver) -> None:
    limits = Limits(containers=3)
    await users.set_limits("ann", limits)
    await users.set_limits("ann", limits)
    assert driver.did == [("ann", limits)]


async def test_paths_count_against_the_quota_and_some_are_counted_ahead(users: UserQuotas) -> None:
    assert await users.take_paths("ann", 3, 64) == 2, "a thousandth of the quota"
    assert await users.usage("ann") == UserUsage(0, 0.0, 5)
    with pytest.raises(QuotaExceeded):
        await users.take_paths("ann", 2000, 0)


async def test_a_container_above_the_quota_is_refused(users: UserQuotas) -> None:
    await users.check_container("ann", 1.0)
    with pytest.raises(QuotaExceeded):
        await users.check_container("ann", 2.0)


async def test_all_places_of_a_user_are_ended_or_only_the_place_of_a_robot(
    users: UserQuotas, driver: QuotaDriver
) -> None:
    reason = NotAuthenticated("this user was removed")
    await users.end_places("ann", reason)
    await users.end_places("ann", reason, "tb1")
    assert driver.did == [("ann", reason), ("robot:ann/tb1", reason)]


def test_news_reach_all_but_their_source_also_if_one_fails() -> None:
    def fail(kind: str, key: str) -> None:
        raise RuntimeError(key)

    news, first, second = News(), list[str](), list[str]()

    def source(kind: str, key: str) -> None:
        first.append(key)

    news.listen(fail)
    news.listen(source)
    news.listen(lambda kind, key: second.append(f"{kind} {key}"))
    news.tell("map", "office")
    news.tell("robot", "tb1", source=source)
    assert (first, second) == (["office"], ["map office", "robot tb1"])
