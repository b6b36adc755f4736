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
from tests.support.engine.specs import planning_spec, robot_config, robot_request

NOW = 100.0


def carried(container: str = "old", robot: str = "tb1", cores: float | None = None) -> RunningContainer:
    spec = of_request(container, robot)
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


def test_what_a_machine_carries_is_counted_and_is_ready_when_it_has_said_hello(master: Master) -> None:
    orders = master.handle(joined("m1", 4, carries=(carried(), carried("old2", "tb2"))))
    assert adopted(orders) == ["old", "old2"] and not started(orders)
    place = master.places[robot_request().key]
    assert (place.machine, place.state, place.pid, place.session) == ("m1", "starting", 42, "s")
    assert sorted(master.machines["m1"].containers) == ["old", "old2"]
    assert master.quotas.used("ann").containers == 2
    assert master.handle(ContainerReady("old", 7)) == []
    assert (place.state, place.pid) == ("ready", 42)
    assert master.handle(PlaceRequested(robot_request())) == [], "the robot finds it when it comes"
    assert master.handle(PlaceReleased(robot_request().key)) == [End("m1", "old")]
    assert master.quotas.used("ann").containers == 1


def test_one_that_dies_is_replaced_in_its_session(master: Master) -> None:
    master.handle(joined("m1", 4, carries=(carried(),)))
    (start,) = master.handle(ContainerLost("old", Unavailable("it ended"), NOW))
    assert isinstance(start, Start) and start.spec.session == "s" != start.spec.id


def test_a_robot_that_waits_for_its_machine_gets_the_clone_that_it_had(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == [], "its clone may run on the other"
    orders = master.handle(joined("m2", 4, carries=(carried(),)))
    assert adopted(orders) == ["old"] and not started(orders)
    assert master.places[robot_request().key].machine == "m2"


def test_a_robot_whose_clone_does_not_come_back_gets_another(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    assert started(master.handle(ReturnTimedOut())) == ["m1"]
    assert adopted(master.handle(joined("m2", 4, carries=(carried(),)))) == [], "a robot has one clone"


def test_the_last_machine_that_returns_ends_the_waiting_and_planning_waits_for_none(master: Master) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    assert started(master.handle(PlaceRequested(planning_request()))) == ["m1"]
    assert started(master.handle(joined("m2", 4))) == ["m1"]


def planning_request() -> PlaceRequest:
    return other(robot_request(), robot=None)


def test_of_two_that_say_they_serve_a_robot_one_is_adopted(master: Master) -> None:
    assert adopted(master.handle(joined("m1", 4, carries=(carried(), carried("old2"), carried())))) == ["old"]
    assert adopted(master.handle(joined("m2", 4, carries=(carried("old3"), carried())))) == []


Change = Callable[[RunningContainer], RunningContainer]

NOT_BELIEVED: dict[str, Change] = {
    "it only plans": lambda told: replace(told, spec=planning_spec("old")),
    "no size": lambda told: replace(told, cores=0.0),
    "odd size": lambda told: replace(told, cores=float("nan")),
    "more than the machine has": lambda told: replace(told, cores=5.0),
    "another map": lambda told: replace(told, spec=replace(told.spec, map=MapVersion("house", "v2"))),
    "another robot file": lambda told: replace(told, spec=replace(told.spec, robot=robot_config("tb1", model="other"))),
    "another size": lambda told: replace(told, spec=replace(told.spec, cores=2.0)),
}


@pytest.mark.parametrize("change", NOT_BELIEVED.values(), ids=NOT_BELIEVED)
def test_what_is_not_what_the_robot_asks_for_is_not_adopted(master: Master, change: Change) -> None:
    master.handle(MachinesExpected(("m2",)))
    master.handle(joined("m1", 4))
    assert master.handle(PlaceRequested(robot_request())) == []
    orders = master.handle(joined("m2", 4, carries=(change(carried()),)))
    assert adopted(orders) == [] and started(orders) == ["m1"]


def test_a_container_that_was_resized_keeps_its_size_and_its_place_that_which_was_asked_for(master: Master) -> None:
    told = carried(cores=2.0)
    assert told.spec.cores != 2.0
    assert adopted(master.handle(joined("m1", 4, carries=(told,)))) == ["old"]
    assert master.machines["m1"].given == master.quotas.used("ann").cores == 2.0
    assert master.handle(PlaceRequested(robot_request())) == []
    master.handle(PlaceReleased(robot_request().key))
    assert master.quotas.used("ann").cores == 0.0


def test_from_a_machine_that_is_drained_what_was_adopted_leaves_when_it_is_ready(master: Master) -> None:
    master.handle(SettingsLoaded({"m2": MachineSettings(draining=True)}, ()))
    master.handle(joined("m1", 4))
    orders = master.handle(joined("m2", 4, carries=(carried(),)))
    assert [type(order) for order in orders] == [Adopt]
    assert [type(order) for order in master.handle(ContainerReady("old", 7))] == [Leave]
