"""An endpoint calls its master, asks it for a planning container from time to time, and goes on while there is none."""

import asyncio
from typing import Any

import pytest

from engine.cloud_client.cloud import AHEAD, BUSY, KEEP, EndpointCloud, PathsAhead
from engine.cloud_client.sessions import EndpointPlaces
from engine.control.master_calls.control_plane import MapCalls, RobotCalls, UserCalls
from engine.control.master_calls.interface import JoinedPlace, MasterCalls
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import MapVersion
from ppaas.clock import ManualClock
from ppaas.errors import QuotaExceeded, Unavailable
from storage.records import Limits
from tests.support.storage import records

VERSION = MapVersion("office", "v1")

KEY = "planning:ann/office"


class Master:
    """Master that opens planning places, or has none free."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []
        self.told: list[tuple[Any, ...]] = []
        self.position: int | None = None
        self.is_up = True
        self.loses = False

    async def call(self, method: object, *arguments: Any) -> object:
        self.asked.append(arguments)
        if self.loses:
            raise Unavailable("the master was lost")
        if method in (RobotCalls.views, MasterCalls.facts):
            return [True]
        return JoinedPlace(KEY, "base_link", self.position)

    def tell(self, method: object, *arguments: Any) -> bool:
        if self.is_up:
            self.told.append((method, *arguments))
        return self.is_up


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def master() -> Master:
    return Master()


@pytest.fixture
def places(clock: ManualClock) -> EndpointPlaces:
    return EndpointPlaces(clock)


@pytest.fixture
def cloud(master: Master, places: EndpointPlaces, clock: ManualClock) -> EndpointCloud:
    return EndpointCloud(master, places, Quotas(Quota()), clock)  # type: ignore[arg-type]


async def use(cloud: EndpointCloud, **labels: str) -> int | None:
    """Use the planning container of a user; return the position in the queue."""
    _, position = await cloud._use_planning("ann", VERSION, labels, True)
    return position


async def test_the_master_is_asked_until_the_container_is_there(
    cloud: EndpointCloud, master: Master, places: EndpointPlaces
) -> None:
    master.position = 2
    assert [await use(cloud), await use(cloud)] == [2, 2]
    assert len(master.asked) == 2
    master.position = None
    places.link(KEY).container = "c1"
    assert await use(cloud) is None
    assert len(master.asked) == 2, "its container is connected"


async def test_the_master_is_asked_again_to_keep_the_container(
    cloud: EndpointCloud, master: Master, places: EndpointPlaces, clock: ManualClock
) -> None:
    await use(cloud)
    places.link(KEY).container = "c1"
    for _ in range(3):
        clock.advance(KEEP + 0.1)
        assert [await use(cloud), await use(cloud)] == [None, None]
    assert len(master.asked) == 4


async def test_a_lost_container_or_a_closed_place_is_asked_for_again(
    cloud: EndpointCloud, master: Master, places: EndpointPlaces
) -> None:
    await use(cloud)
    places.link(KEY).container = "c1"
    places.link(KEY).container = None
    await use(cloud)
    places.link(KEY).container = "c2"
    places.close(KEY, Unavailable("the planning container was idle"))
    await use(cloud)
    assert len(master.asked) == 3


async def test_each_set_of_labels_has_a_container_of_its_own(
    cloud: EndpointCloud, master: Master, places: EndpointPlaces
) -> None:
    await use(cloud)
    places.link(KEY).container = "c1"
    await use(cloud, zone="hall-2")
    assert [labels for _, _, labels, _ in master.asked] == [{}, {"zone": "hall-2"}]


async def test_states_of_robots_are_not_known_while_no_master_answers(cloud: EndpointCloud, master: Master) -> None:
    assert await cloud.robot_views([("ann", "tb1")]) == [True]
    master.loses = True
    assert await cloud.robot_views([("ann", "tb1"), ("ann", "tb2")]) == [None, None]
    master.is_up = False
    asked = len(master.asked)
    assert await cloud.robot_views([("ann", "tb1")]) == [None]
    assert len(master.asked) == asked, "nobody waits for a master"


async def test_others_know_no_facts_while_no_master_answers(cloud: EndpointCloud, master: Master) -> None:
    assert await cloud.facts("refusal", "ann", "tb1") == [True]
    master.loses = True
    assert await cloud.facts("refusal", "ann", "tb1") == []


async def test_limits_are_sent_once_and_again_to_each_new_master(cloud: EndpointCloud, master: Master) -> None:
    few = Limits(containers=1)
    for _ in range(2):
        await cloud.set_limits("ann", few)
    assert cloud.quotas.of("ann").containers == 1
    assert master.told == [(UserCalls.set_limits, "ann", few)]
    cloud.master_found()
    assert master.told == [(UserCalls.set_limits, "ann", few)] * 2


async def test_changes_that_no_master_got_are_announced_to_the_next_one(cloud: EndpointCloud, master: Master) -> None:
    master.is_up = False
    cloud.announce("map", "office")
    cloud.announce("user", "ann")
    assert master.told == []
    master.is_up = True
    cloud.master_found()
    cloud.master_found()
    assert master.told == [(MasterCalls.announce, "map", "office"), (MasterCalls.announce, "user", "ann")]


async def test_a_change_of_a_map_waits_for_no_master(cloud: EndpointCloud, master: Master) -> None:
    await cloud.maps.changed(records.house())
    master.is_up = False
    await cloud.maps.changed(records.house())
    assert master.told == [(MapCalls.changed, records.house())]
    assert master.asked == []


class CountingMaster:
    """CountingMaster that counts paths, as long as there are some left."""

    def __init__(self) -> None:
        self.left = 10_000
        self.calls: list[tuple[str, int, int]] = []

    async def take(self, user: str, paths: int, ahead: int) -> int:
        self.calls.append((user, paths, ahead))
        await asyncio.sleep(0)
        if paths > self.left:
            raise QuotaExceeded("too many")
        self.left -= paths
        more = min(ahead, self.left)
        self.left -= more
        return more


@pytest.fixture
def counting_master() -> CountingMaster:
    return CountingMaster()


@pytest.fixture
def paths(counting_master: CountingMaster, clock: ManualClock) -> PathsAhead:
    return PathsAhead(counting_master.take, clock)


async def test_users_who_request_few_paths_are_counted_exactly(
    paths: PathsAhead, counting_master: CountingMaster, clock: ManualClock
) -> None:
    for _ in range(5):
        await paths.count("ann", 2)
        clock.advance(BUSY)
    assert counting_master.calls == [("ann", 2, 0)] * 5


async def test_the_master_is_asked_once_for_many_paths(paths: PathsAhead, counting_master: CountingMaster) -> None:
    for _ in range(2 + 3 * (AHEAD + 1)):
        await paths.count("ann", 1)
    assert counting_master.calls == [("ann", 1, 0), *[("ann", 1, AHEAD)] * 4]
    assert 10_000 - counting_master.left == 1 + 4 * (AHEAD + 1)


async def test_many_clients_take_ahead_once(paths: PathsAhead, counting_master: CountingMaster) -> None:
    await asyncio.gather(*(paths.count("ann", 1) for _ in range(20)))
    assert [ahead for *_, ahead in counting_master.calls] == [0, AHEAD, *[0] * 18]
    assert 10_000 - counting_master.left == 20 + AHEAD


async def test_paths_that_were_counted_ahead_are_forgotten_in_time(
    paths: PathsAhead, counting_master: CountingMaster, clock: ManualClock
) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    clock.advance(KEEP)
    await paths.count("ann", 1)
    assert [ahead for *_, ahead in counting_master.calls] == [0, AHEAD, 0]


async def test_a_changed_quota_is_asked_for_at_once(paths: PathsAhead, counting_master: CountingMaster) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    paths.forget("ann")
    counting_master.left = 0
    with pytest.raises(QuotaExceeded):
        await paths.count("ann", 1)


async def test_refused_paths_use_nothing_and_users_are_counted_alone(
    paths: PathsAhead, counting_master: CountingMaster
) -> None:
    for _ in range(3):
        await paths.count("ann", 1)
    counting_master.left = 0
    with pytest.raises(QuotaExceeded):
        await paths.count("ann", AHEAD)
    await paths.count("ann", AHEAD - 1)
    with pytest.raises(QuotaExceeded):
        await paths.count("bob", 1)
