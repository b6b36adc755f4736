"""Tests of adoption: containers of an earlier cloud process, and the places that adopt them."""

from collections.abc import Callable
from dataclasses import replace as other

import pytest
from msgspec.structs import replace

from engine.master.balancers.first_fit import FirstFit
from engine.master.events import (
    ContainerLost,
    ContainerReady,
    MachinesExpected,
    PlaceReleased,
    PlaceRequested,
    ReturnTimedOut,
    SettingsLoaded,
)
from engine.master.master import Master
from engine.master.orders import Adopt, End, Leave, Order, Start
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.protocols.control_link import RunningContainer
from engine.specs.containers import ContainerSpec, MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import (
    coordinator_request,
    coordinator_spec,
    planning_spec,
    robot_config,
    robot_request,
    traffic_request,
    traffic_spec,
)

NOW = 100.0


def carried(name: str = "old", robot: str = "tb1", cores: float | None = None) -> RunningContainer:
    spec = of_request(name, robot)
    return RunningContainer(spec, spec.cores if cores is None else cores, "secret", 42)


def of_request(container: str, robot: str) -> ContainerSpec:
    request = robot_request(robot)
    return ContainerSpec(container, request.user, request.map, request.cores, request.robot, session="s")


def adopted(orders: list[Order]) -> list[str]:
    return [order.carried.spec.id for order in orders if isinstance(order, Adopt)]


def started(orders: list[Order]) -> list[str]:
    return [order.machine for order in orders if isinstance(order, Start)]


@pytest.fixture
def master() -> Master:
    return Master(FirstFit(), Quotas(Quota(containers=2)))


def test_adopted_containers_are_counted_and_ready_after_hello(master: Master) -> None:
    orders = master.handle(joined("m1", 4, carries=(carried(), carried("old2", "tb2"))))
    assert adopted(orders) == ["old", "old2"] and not started(orders)
    place = master.places[robot_request().key]
    assert (place.machine, place.state, place.pid, place.session) == ("m1", "starting", 42, "s")
    assert sorted(master.machines["m1"].containers) == ["old", "old2"]
    assert master.quotas.used("ann").containers == 2
    assert master.handle(ContainerReady("old", 7)) == []
    assert (place.state, place.pid) == ("ready", 42)
    assert master.handle(PlaceRequested(robot_request())) == [], "the robot gets the adopted container"
    assert master.handle(PlaceReleased(robot_request().key)) == [End("m1", "old")]
    assert master.quotas.used("ann").containers == 1


def test_a_coordinator_is_adopted_once_and_its_place_is_not_that_of_planning(master: Master) -> None:
    spec = replace(coordinator_spec("old", version=MapVersion("house", "v2")), session="s")
    orders = master.handle(joined("m1", 4, carries=(RunningContainer(spec, 0.5, "secret", 42),)))
    assert adopted(orders) == ["old"]
    request = master.request_of("people:ann/house")
    assert request is not None and request.group_node == "people" and request.map.version == "v2"
    assert master.places["people:ann/house"].cores == 0.5
    again = master.handle(joined("m2", 4, carries=(RunningContainer(replace(spec, id="old2"), 0.5, "secret", 43),)))
    assert adopted(again) == []


def test_a_traffic_node_is_adopted_beside_the_coordinator_of_the_same_robots(master: Master) -> None:
    specs = (traffic_spec("old"), coordinator_spec("old2"))
    carries = tuple(RunningContainer(replace(spec, session="s"), 0.25, "secret", 42) for spec in specs)
    assert adopted(master.handle(joined("m1", 4, carries=carries))) == ["old", "old2"]
    assert master.request_of("traffic:ann/house") == traffic_request()
    assert master.request_of("people:ann/house") == coordinator_request()
    assert master.quotas.used("ann").containers == 2


@pytest.mark.parametrize("request_", [coordinator_request(), traffic_request()], ids=["people", "traffic"])
def test_the_node_of_a_group_waits_for_machines_that_may_still_run_it(master: Master, request_: PlaceRequest) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(request_)) == []
    assert started(master.handle(ReturnTimedOut())) == ["m1"]


def test_adopted_container_that_exits_is_replaced_in_its_session(master: Master) -> None:
    master.handle(joined("m1", 4, carries=(carried(),)))
    (start,) = master.handle(ContainerLost("old", Unavailable("it ended"), NOW))
    assert isinstance(start, Start) and start.spec.session == "s" != start.spec.id


def test_robot_gets_its_clone_back_with_the_returning_machine(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == [], "its clone may run on the other machine"
    orders = master.handle(joined("m2", 4, carries=(carried(),)))
    assert adopted(orders) == ["old"] and not started(orders)
    assert master.places[robot_request().key].machine == "m2"


def test_robot_gets_a_new_clone_if_its_machine_does_not_return(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    assert started(master.handle(ReturnTimedOut())) == ["m1"]
    assert adopted(master.handle(joined("m2", 4, carries=(carried(),)))) == [], "a robot has one clone"


def test_requests_wait_until_the_last_expected_machine_returns(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    assert started(master.handle(PlaceRequested(planning_request()))) == ["m1"]
    assert started(master.handle(joined("m2", 4))) == ["m1"]


def planning_request() -> PlaceRequest:
    return other(robot_request(), robot=None)


def test_only_one_container_of_a_robot_is_adopted(master: Master) -> None:
    assert adopted(master.handle(joined("m1", 4, carries=(carried(), carried("old2"), carried())))) == ["old"]
    assert adopted(master.handle(joined("m2", 4, carries=(carried("old3"), carried())))) == []


Change = Callable[[RunningContainer], RunningContainer]

NOT_ADOPTABLE: dict[str, Change] = {
    "it only plans": lambda container: replace(container, spec=planning_spec("old")),
    "no size": lambda container: replace(container, cores=0.0),
    "odd size": lambda container: replace(container, cores=float("nan")),
    "more than the machine has": lambda container: replace(container, cores=5.0),
    "another map": lambda container: replace(container, spec=replace(container.spec, map=MapVersion("house", "v2"))),
    "another robot file": lambda container: replace(
        container, spec=replace(container.spec, robot=robot_config("tb1", model="other"))
    ),
    "another size": lambda container: replace(container, spec=replace(container.spec, cores=2.0)),
}


@pytest.mark.parametrize("change", NOT_ADOPTABLE.values(), ids=NOT_ADOPTABLE)
def test_container_that_differs_from_the_request_is_not_adopted(master: Master, change: Change) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    orders = master.handle(joined("m2", 4, carries=(change(carried()),)))
    assert adopted(orders) == [] and started(orders) == ["m1"]


def test_adopted_container_keeps_its_resized_cores(master: Master) -> None:
    container = carried(cores=2.0)
    assert container.spec.cores != 2.0
    assert adopted(master.handle(joined("m1", 4, carries=(container,)))) == ["old"]
    assert master.machines["m1"].given == master.quotas.used("ann").cores == 2.0
    assert master.handle(PlaceRequested(robot_request())) == []
    master.handle(PlaceReleased(robot_request().key))
    assert master.quotas.used("ann").cores == 0.0


def test_resized_container_that_is_adopted_again_is_counted_once(master: Master) -> None:
    container = carried(cores=2.0)
    for _ in range(2):
        assert adopted(master.handle(joined("m1", 4, carries=(container,)))) == ["old"]
        assert master.quotas.used("ann").cores == 2.0


def test_adopted_container_leaves_a_drained_machine_when_ready(master: Master) -> None:
    master.handle(SettingsLoaded({"m2": MachineSettings(draining=True)}, ()))
    master.handle(joined("m1", 4))
    orders = master.handle(joined("m2", 4, carries=(carried(),)))
    assert [type(order) for order in orders] == [Adopt]
    assert [type(order) for order in master.handle(ContainerReady("old", 7))] == [Leave]
