"""Tests of the master as a pure state machine."""

from collections.abc import Sequence

import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.balancers.ppaas import SameMap
from engine.master.events import (
    ContainerLaunched,
    ContainerLost,
    ContainerReady,
    MachineLeft,
    PlaceReleased,
    PlaceRequested,
    ResizeRequested,
)
from engine.master.master import Master
from engine.master.orders import Close, End, Resize, Start
from engine.master.places import CRASH_LIMIT, CRASH_WINDOW, RESTART_DELAYS, PlaceRequest
from engine.master.quotas import Quota, Quotas, Used
from engine.specs.containers import MapVersion, RobotConfig
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, InvalidMap, InvalidParameter, NotFound, QuotaExceeded, Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import HOUSE, robot_config

MAP = MapVersion("office", "v1")
NOW = 100.0


def robot(name: str, user: str = "alice", cores: float = 1.0) -> PlaceRequest:
    config = RobotConfig(name, "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    return PlaceRequest(user, MAP, cores, config)


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def master() -> Master:
    return Master(FirstFit(), Quotas(Quota(containers=8, cores=8.0)))


def started(orders: Sequence[object]) -> list[Start]:
    return [order for order in orders if isinstance(order, Start)]


def test_container_goes_to_the_first_machine_with_capacity(master: Master) -> None:
    master.handle(joined("m1", 1))
    master.handle(joined("m2", 2))
    places = [started(master.handle(PlaceRequested(robot(f"r{n}"))))[0].machine for n in range(6)]
    assert places == ["m1"] * 4 + ["m2"] * 2


def test_opening_an_open_place_gives_no_orders(master: Master) -> None:
    master.handle(joined("m1"))
    assert len(master.handle(PlaceRequested(robot("r1")))) == 1
    assert master.handle(PlaceRequested(robot("r1"))) == []


def test_robots_of_two_users_may_have_the_same_name(master: Master) -> None:
    master.handle(joined("m1"))
    for user in ("alice", "bob"):
        assert started(master.handle(PlaceRequested(robot("r1", user))))


@pytest.mark.parametrize("cores", [0.0, -1.0, float("nan"), float("inf")])
def test_size_must_be_positive_and_finite(master: Master, cores: float) -> None:
    master.handle(joined("m1"))
    with pytest.raises(InvalidParameter):
        master.handle(PlaceRequested(robot("r1", cores=cores)))


def test_size_above_the_largest_machine_is_refused(master: Master) -> None:
    master.handle(joined("m1", 2))
    with pytest.raises(QuotaExceeded, match="2"):
        master.handle(PlaceRequested(robot("r1", cores=3.0)))


def test_exceeded_quota_is_refused_by_name() -> None:
    master = Master(FirstFit(), Quotas(Quota(containers=2, cores=1.5)))
    master.handle(joined("m1"))
    master.handle(PlaceRequested(robot("r1")))
    with pytest.raises(QuotaExceeded, match=r"1\.5 cores"):
        master.handle(PlaceRequested(robot("r2", cores=1.0)))
    master.handle(PlaceRequested(robot("r2", cores=0.5)))
    with pytest.raises(QuotaExceeded, match="2 containers"):
        master.handle(PlaceRequested(robot("r3", cores=0.1)))
    assert started(master.handle(PlaceRequested(robot("r1", "bob"))))


def test_full_cloud_refuses_a_place_and_keeps_no_state(master: Master) -> None:
    master.handle(joined("m1", 1))
    for n in range(4):
        master.handle(PlaceRequested(robot(f"r{n}")))
    with pytest.raises(Unavailable, match="room"):
        master.handle(PlaceRequested(robot("r5")))
    assert len(master.places) == 4


def test_places_wait_for_the_first_machine(master: Master) -> None:
    assert master.handle(PlaceRequested(robot("r1"))) == []
    assert [order.place for order in started(master.handle(joined("m1")))] == ["robot:alice/r1"]


def test_lost_container_is_replaced_with_a_new_id(master: Master) -> None:
    master.handle(joined("m1"))
    first = started(master.handle(PlaceRequested(robot("r1"))))[0].spec.id
    master.handle(ContainerReady(first, 77))
    assert master.places["robot:alice/r1"].state == "ready"
    second = started(master.handle(ContainerLost(first, Unavailable("gone"), NOW)))[0].spec.id
    assert second != first
    assert master.handle(ContainerLost(first, Unavailable("late news"), NOW)) == []
    assert master.handle(ContainerReady(first, 77)) == []
    assert master.places["robot:alice/r1"].state == "starting"


def test_process_id_reported_by_the_machine_takes_precedence(master: Master) -> None:
    master.handle(joined("m1"))
    first, second = (started(master.handle(PlaceRequested(robot(name))))[0].spec.id for name in ("r1", "r2"))
    master.handle(ContainerLaunched("m1", first, 4711))
    for container in (first, second):
        master.handle(ContainerReady(container, 7))
    master.handle(ContainerLaunched("m1", second, 4712))
    assert {place.pid for place in master.places.values()} == {4711, 4712}


def test_crash_loop_closes_the_place_with_the_reason(master: Master, clock: ManualClock) -> None:
    master.handle(joined("m1"))
    orders = master.handle(PlaceRequested(robot("r1")))
    for _ in range(CRASH_LIMIT):
        orders = master.handle(ContainerLost(started(orders)[0].spec.id, Unavailable("boom"), clock()))
        clock.advance(1.0)
    orders = master.handle(ContainerLost(started(orders)[0].spec.id, Unavailable("boom"), clock()))
    (close,) = orders
    assert isinstance(close, Close) and "boom" in str(close.reason)
    assert not master.places and not master.machines["m1"].containers


def test_rare_crashes_are_not_a_crash_loop(master: Master, clock: ManualClock) -> None:
    master.handle(joined("m1"))
    orders = master.handle(PlaceRequested(robot("r1")))
    for _ in range(3 * CRASH_LIMIT):
        orders = master.handle(ContainerLost(started(orders)[0].spec.id, Unavailable("boom"), clock()))
        clock.advance(CRASH_WINDOW)
    assert len(started(orders)) == 1


def test_container_that_can_never_start_is_not_retried(master: Master) -> None:
    master.handle(joined("m1"))
    first = started(master.handle(PlaceRequested(robot("r1"))))[0].spec.id
    (close,) = master.handle(ContainerLost(first, InvalidMap("no map at all"), NOW))
    assert isinstance(close, Close) and isinstance(close.reason, InvalidMap)


def test_conflict_closes_the_place_without_a_retry(master: Master) -> None:
    master.handle(joined("m1"))
    (start,) = started(master.handle(PlaceRequested(robot("r1"))))
    (close,) = master.handle(ContainerLost(start.spec.id, Conflict("the map has a newer version"), NOW))
    assert isinstance(close, Close) and isinstance(close.reason, Conflict)
    assert master.places == {}


def test_repeated_crashes_delay_the_replacement(master: Master, clock: ManualClock) -> None:
    master.handle(joined("m1"))
    (start,) = started(master.handle(PlaceRequested(robot("r1"))))
    assert start.delay == 0.0
    delays = []
    for _ in range(CRASH_LIMIT):
        (start,) = started(master.handle(ContainerLost(start.spec.id, Unavailable("it crashed"), clock())))
        delays.append(start.delay)
    assert tuple(delays) == RESTART_DELAYS
    clock.advance(2 * CRASH_WINDOW)
    (start,) = started(master.handle(ContainerLost(start.spec.id, Unavailable("it crashed"), clock())))
    assert start.delay == 0.0


def test_containers_of_a_place_share_its_session(master: Master) -> None:
    master.handle(joined("m1"))
    (first,) = started(master.handle(PlaceRequested(robot("r1"))))
    (second,) = started(master.handle(ContainerLost(first.spec.id, Unavailable("it crashed"), NOW)))
    third = started([*master.handle(MachineLeft("m1")), *master.handle(joined("m1"))])[0]
    assert {start.spec.session for start in (first, second, third)} == {first.spec.id}
    master.handle(PlaceReleased(robot("r1").key))
    (third_place,) = started(master.handle(PlaceRequested(robot("r1"))))
    assert third_place.spec.session == third_place.spec.id


def test_waiting_place_is_filled_when_capacity_is_freed(master: Master) -> None:
    master.handle(joined("m1", 1))
    master.handle(joined("m2", 1))
    for number in range(8):
        master.handle(PlaceRequested(robot(f"r{number}")))
    assert master.handle(MachineLeft("m2")) == []
    waiting = [key for key, place in master.places.items() if place.state == "waiting"]
    assert len(waiting) == 4
    end, start = master.handle(PlaceReleased(robot("r0").key))
    assert isinstance(end, End)
    assert isinstance(start, Start) and start.place == waiting[0]
    close, start = master.handle(ContainerLost(start.spec.id, InvalidMap("not square"), NOW))
    assert isinstance(close, Close)
    assert isinstance(start, Start) and start.place == waiting[1]


def test_places_of_a_lost_machine_are_filled_elsewhere(master: Master) -> None:
    master.handle(joined("m1"))
    master.handle(joined("m2"))
    master.handle(PlaceRequested(robot("r1")))
    master.handle(PlaceRequested(robot("r2")))
    again = started(master.handle(MachineLeft("m1")))
    assert {order.place for order in again} == {"robot:alice/r1", "robot:alice/r2"}
    assert {order.machine for order in again} == {"m2"}


def test_machine_that_rejoins_has_no_old_containers(master: Master) -> None:
    master.handle(joined("m1"))
    old = started(master.handle(PlaceRequested(robot("r1"))))[0].spec.id
    again = started(master.handle(joined("m1")))
    assert len(again) == 1 and again[0].spec.id != old
    assert list(master.machines["m1"].containers) == [again[0].spec.id]


def test_released_place_ends_its_container(master: Master) -> None:
    master.handle(joined("m1"))
    container = started(master.handle(PlaceRequested(robot("r1"))))[0].spec.id
    assert master.handle(PlaceReleased("robot:alice/r1")) == [End("m1", container)]
    assert master.handle(PlaceReleased("robot:alice/r1")) == []


def request(name: str = "tb1", cores: float = 1.0) -> PlaceRequest:
    return PlaceRequest("ann", HOUSE, cores, robot_config(name))


@pytest.fixture
def quotas() -> Quotas:
    return Quotas(Quota(cores=4.0))


@pytest.fixture
def small_master(quotas: Quotas) -> Master:
    made = Master(SameMap(), quotas)
    made.handle(joined("m1", 2, memory=8 << 30))
    return made


def ready(small_master: Master, name: str = "tb1", cores: float = 1.0) -> str:
    """Open a place; return its container, which is ready."""
    [start] = small_master.handle(PlaceRequested(request(name, cores)))
    assert isinstance(start, Start)
    small_master.handle(ContainerReady(start.spec.id, 77))
    return start.spec.id


@pytest.mark.parametrize("cores", [2.0, 0.25])
def test_resized_container_counts_with_its_new_size(small_master: Master, quotas: Quotas, cores: float) -> None:
    container = ready(small_master)
    assert small_master.handle(ResizeRequested(container, cores)) == [Resize("m1", container, cores)]
    assert (small_master.machines["m1"].given, quotas.used("ann")) == (cores, Used(1, cores))
    small_master.handle(PlaceReleased("robot:ann/tb1"))
    assert (small_master.machines["m1"].given, quotas.used("ann")) == (0.0, Used())


def test_replacement_has_the_new_size(small_master: Master) -> None:
    container = ready(small_master)
    small_master.handle(ResizeRequested(container, 1.5))
    [start] = small_master.handle(ContainerLost(container, Unavailable("boom"), 100.0))
    assert isinstance(start, Start) and start.spec.cores == 1.5


def test_reopened_place_has_the_requested_size(small_master: Master) -> None:
    small_master.handle(ResizeRequested(ready(small_master), 1.5))
    small_master.handle(PlaceReleased("robot:ann/tb1"))
    [start] = small_master.handle(PlaceRequested(request()))
    assert isinstance(start, Start) and start.spec.cores == 1.0


def test_resize_above_the_quota_is_refused(small_master: Master) -> None:
    first, second, _ = (
        ready(small_master, "tb1", 2.0),
        ready(small_master, "tb2", 1.5),
        ready(small_master, "tb3", 0.25),
    )
    with pytest.raises(QuotaExceeded, match=r"4 cores and has 3\.75; 0\.5 more"):
        small_master.handle(ResizeRequested(second, 2.0))
    small_master.handle(ResizeRequested(second, 1.75))
    small_master.handle(ResizeRequested(first, 0.5))


@pytest.mark.parametrize(
    ("cores", "error"), [(0.0, InvalidParameter), (float("nan"), InvalidParameter), (3.0, QuotaExceeded)]
)
def test_invalid_size_is_refused_and_changes_nothing(
    small_master: Master, quotas: Quotas, cores: float, error: type[Exception]
) -> None:
    container = ready(small_master)
    with pytest.raises(error):
        small_master.handle(ResizeRequested(container, cores))
    assert (small_master.machines["m1"].given, quotas.used("ann").cores) == (1.0, 1.0)


def test_resize_above_the_free_cores_is_refused_with_their_number() -> None:
    small_master = Master(SameMap(), Quotas())
    small_master.handle(joined("m1", 2, memory=8 << 30))
    first, *_ = [ready(small_master, f"tb{number}", cores) for number, cores in enumerate([1.0, 2.0, 2.0, 2.0, 0.5])]
    with pytest.raises(Unavailable, match=r"'m1' has 0\.5 free cores, but 0\.75 more are needed"):
        small_master.handle(ResizeRequested(first, 1.75))
    assert small_master.handle(ResizeRequested(first, 1.5))


def test_unready_or_unknown_container_cannot_be_resized(small_master: Master) -> None:
    [start] = small_master.handle(PlaceRequested(request()))
    assert isinstance(start, Start)
    with pytest.raises(Unavailable, match="when it is ready"):
        small_master.handle(ResizeRequested(start.spec.id, 0.5))
    with pytest.raises(NotFound):
        small_master.handle(ResizeRequested("c99", 0.5))
