"""Stops of robots in the master: orders to clones and their confirmations, releases by name, and what is stored."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from engine.control import robot_stops
from engine.control.robot_stops import RobotStops, StopBook, StopOrder
from engine.links.place_link import PlaceLink
from engine.master.places import PlaceRequest, robot_key
from engine.protocols import robot_link
from engine.protocols.robot_link import SetStops, StopsInForce
from engine.specs.containers import MapVersion
from engine.specs.robot_stops import store_stops, stored_stops
from ppaas.clock import ManualClock
from ppaas.errors import NotPermitted, Unavailable
from ppaas.messages.health.stops import ALL, MAP, ROBOT, RobotStop
from storage.memory.store import MemoryStore
from tests.support.endpoints.still_place import StillStream
from tests.support.engine.specs import robot_request
from tests.support.waiting import until

EVERY = RobotStop(ALL, "", "ann", 1.0, "a pallet fell")
HALL = RobotStop(MAP, "hall", "ann", 2.0)
OWN = RobotStop(ROBOT, "tb1", "bob", 3.0)
NONE = StopsInForce()


class Clone(StillStream):
    """Container that does what it is ordered, unless it is deaf."""

    def __init__(self, link: PlaceLink, stops: StopsInForce | None, *, deaf: bool) -> None:
        super().__init__()
        self.link, self.deaf = link, deaf
        self.stops = stops
        link.begin(robot_link.Hello("c1", "", 7, 0, [], [], [], stops=stops), self)

    def write(self, frame: robot_link.ToContainer) -> None:
        super().write(frame)
        if isinstance(frame, SetStops) and not self.deaf:
            self.report(StopsInForce(frame.stops))

    def report(self, stops: StopsInForce) -> None:
        """Report stops after a while, as over a link."""
        self.stops = stops
        asyncio.get_running_loop().call_soon(self.link.take, stops)

    @property
    def holds(self) -> tuple[RobotStop, ...]:
        assert self.stops is not None
        return self.stops.stops


class Store(MemoryStore):
    """Store that the test breaks."""

    broken = False

    def save_clone(self, *args: object) -> None:
        if self.broken:
            raise Unavailable("the store is away")
        super().save_clone(*args)  # type: ignore[arg-type]

    def remove_clone(self, user: str, robot: str) -> None:
        if self.broken:
            raise Unavailable("the store is away")
        super().remove_clone(user, robot)


class Cloud:
    """Open places of robots, and a master that leads."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.requests: dict[str, PlaceRequest] = {}
        self.links: dict[str, PlaceLink] = {}
        self.stops = RobotStops(self, store, ManualClock(9.0))

    def place(self, key: str) -> PlaceLink | None:
        return self.links.get(key)

    def request_of(self, key: str) -> PlaceRequest | None:
        return self.requests.get(key)

    def open(self, robot: str, map_id: str = "house", user: str = "ann") -> str:
        key = robot_key(user, robot)
        self.requests[key] = robot_request(robot, user, MapVersion(map_id, "v"))
        self.links[key] = PlaceLink(key)
        self.stops.place_opened(key)
        return key

    def connect(
        self, robot: str, map_id: str = "house", user: str = "ann", *, stops: StopsInForce | None = NONE,
        deaf: bool = False,
    ) -> Clone:  # fmt: skip
        return Clone(self.links[self.open(robot, map_id, user)], stops, deaf=deaf)


@pytest.fixture
def store() -> Store:
    return Store()


@pytest.fixture
async def cloud(store: Store, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Cloud]:
    monkeypatch.setattr(robot_stops, "CONFIRMATION", 0.1)
    made = Cloud(store)
    yield made
    await made.stops.close()


def order(stop: RobotStop, user: str = "ann") -> list[StopOrder]:
    return [StopOrder(user, stop)]


# -- book --------------------------------------------------------------------------------------------------------------


def test_the_first_stop_of_a_name_stays_until_it_is_released() -> None:
    book = StopBook([EVERY])
    later = RobotStop(ALL, "", "bob", 5.0)
    assert book.add(later) is EVERY
    assert book.of("tb1", "house") == (EVERY,)
    assert book.release(ALL, "", "ann", of_others=False) is EVERY
    assert book.release(ALL, "", "ann", of_others=False) is None
    assert book.add(later) is later


def test_a_stop_of_another_user_is_released_only_with_the_right_to() -> None:
    book = StopBook([OWN])
    with pytest.raises(NotPermitted, match="'bob'"):
        book.release(ROBOT, "tb1", "carl", of_others=False)
    assert book.release(ROBOT, "tb1", "carl", of_others=True) is OWN


# -- orders ------------------------------------------------------------------------------------------------------------


async def test_a_stop_reaches_the_clones_that_it_applies_to_and_is_stored(cloud: Cloud, store: Store) -> None:
    here, there, others = cloud.connect("tb1", "hall"), cloud.connect("tb2"), cloud.connect("tb1", "hall", "bob")
    [report] = await cloud.stops.stop(order(HALL))
    assert (report.stop, report.standing, report.unconfirmed) == (HALL, ("tb1",), ())
    assert (here.holds, there.holds, others.holds) == ((HALL,), (), ())
    assert stored_stops(store, "ann") == (HALL,)
    assert stored_stops(store, "bob") == ()


async def test_caches_hear_when_stops_were_stored(cloud: Cloud, store: Store) -> None:
    heard: list[tuple[str, tuple[RobotStop, ...]]] = []
    cloud.stops.stored = lambda user: heard.append((user, stored_stops(store, user)))
    await cloud.stops.stop(order(HALL))
    await cloud.stops.release("ann", *HALL.key, "ann", True)
    assert heard == [("ann", (HALL,)), ("ann", ())]


async def test_a_second_stop_is_answered_with_the_first(cloud: Cloud) -> None:
    await cloud.stops.stop(order(EVERY))
    [report] = await cloud.stops.stop(order(RobotStop(ALL, "", "bob", 9.0, "later")))
    assert report.stop == EVERY


async def test_clones_that_do_not_confirm_are_named(cloud: Cloud) -> None:
    cloud.connect("tb1")
    cloud.connect("tb2", deaf=True)
    cloud.connect("tb3", stops=None)
    cloud.open("tb4")
    [report] = await cloud.stops.stop(order(EVERY))
    assert (report.standing, report.unconfirmed) == (("tb1",), ("tb2", "tb3"))


async def test_a_robot_that_drives_by_itself_stands_only_once_it_has_confirmed(cloud: Cloud) -> None:
    clone = cloud.connect("tb1", deaf=True)
    clone.report(StopsInForce((EVERY,), unheard=True))
    [report] = await cloud.stops.stop(order(EVERY))
    assert (report.standing, report.unconfirmed) == ((), ("tb1",))
    clone.report(StopsInForce((EVERY,)))
    [report] = await cloud.stops.stop(order(EVERY))
    assert (report.standing, report.unconfirmed) == (("tb1",), ())


async def test_one_call_stops_robots_of_several_users(cloud: Cloud) -> None:
    mine, theirs = cloud.connect("tb1"), cloud.connect("tb1", user="bob")
    orders = [*order(EVERY), *order(RobotStop(ROBOT, "tb1", "ann", 4.0), "bob")]
    assert [report.standing for report in await cloud.stops.stop(orders)] == [("tb1",), ("tb1",)]
    assert [stop.scope for clone in (mine, theirs) for stop in clone.holds] == [ALL, ROBOT]


# -- clones that come later, and masters -------------------------------------------------------------------------------


async def test_a_clone_that_reports_other_stops_gets_its_own(cloud: Cloud) -> None:
    await cloud.stops.stop(order(EVERY))
    late = cloud.connect("tb1")
    await until(lambda: late.holds == (EVERY,))
    stale = cloud.connect("tb2", stops=StopsInForce((EVERY, HALL)))
    await until(lambda: stale.holds == (EVERY,))


async def test_a_master_that_takes_over_knows_what_is_stored_and_corrects_clones(store: Store) -> None:
    store_stops(store, "ann", [EVERY], 1.0)
    cloud = Cloud(store)
    forgotten, known = cloud.connect("tb1"), cloud.connect("tb2", stops=StopsInForce((EVERY,)))
    await until(lambda: forgotten.holds == (EVERY,))
    assert known.take(SetStops) == []
    await cloud.stops.close()


async def test_a_place_that_was_closed_is_forgotten(cloud: Cloud) -> None:
    clone = cloud.connect("tb1")
    del cloud.links[robot_key("ann", "tb1")], cloud.requests[robot_key("ann", "tb1")]
    [report] = await cloud.stops.stop(order(EVERY))
    assert (report.standing, clone.holds) == ((), ())


async def test_a_request_of_a_client_is_stored_and_reported_once(cloud: Cloud, store: Store) -> None:
    heard: list[tuple[str, RobotStop]] = []
    cloud.stops.requested = lambda user, stop: heard.append((user, stop))
    clone = cloud.connect("tb1")
    clone.report(StopsInForce(requested=(OWN,)))
    await until(lambda: clone.holds == (OWN,))
    await until(lambda: stored_stops(store, "ann") == (OWN,))
    clone.report(StopsInForce(requested=(RobotStop(ROBOT, "tb1", "x", 7.0),)))
    await until(lambda: clone.holds == (OWN,))
    assert heard == [("ann", OWN)]


# -- releases, and a store that fails ----------------------------------------------------------------------------------


async def test_a_release_leaves_the_other_stops(cloud: Cloud, store: Store) -> None:
    clone = cloud.connect("tb1", "hall")
    for stop in (EVERY, HALL, OWN):
        await cloud.stops.stop(order(stop))
    assert await cloud.stops.release("ann", MAP, "hall", "ann", False) == HALL
    await until(lambda: clone.holds == (EVERY, OWN))
    with pytest.raises(NotPermitted):
        await cloud.stops.release("ann", ROBOT, "tb1", "carl", False)
    assert await cloud.stops.release("ann", ROBOT, "tb1", "carl", True) == OWN
    assert await cloud.stops.release("ann", ALL, "", "ann", False) == EVERY
    await until(lambda: clone.holds == ())
    assert stored_stops(store, "ann") == ()
    assert await cloud.stops.release("ann", ALL, "", "ann", False) is None


async def test_a_stop_that_cannot_be_stored_holds_and_is_refused(cloud: Cloud, store: Store) -> None:
    clone = cloud.connect("tb1")
    store.broken = True
    with pytest.raises(Unavailable, match="stopped, but that could not be stored: the store is away"):
        await cloud.stops.stop(order(EVERY))
    assert clone.holds == (EVERY,)
    store.broken = False
    await cloud.stops.stop(order(EVERY))
    assert stored_stops(store, "ann") == (EVERY,)


async def test_a_release_that_cannot_be_stored_leaves_the_robots_stopped(cloud: Cloud, store: Store) -> None:
    clone = cloud.connect("tb1")
    await cloud.stops.stop(order(EVERY))
    store.broken = True
    with pytest.raises(Unavailable, match="stay stopped"):
        await cloud.stops.release("ann", ALL, "", "ann", False)
    await asyncio.sleep(0.0)
    assert (clone.holds, stored_stops(store, "ann")) == ((EVERY,), (EVERY,))
    store.broken = False
    assert await cloud.stops.release("ann", ALL, "", "ann", False) == EVERY
