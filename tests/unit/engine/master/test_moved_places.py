"""Places of robots that are brought to other maps."""

import msgspec
import pytest

from engine.master.balancers.ppaas import SameMap
from engine.master.events import (
    ContainerLost,
    ContainerReady,
    MachineLeft,
    MapChanged,
    PlaceMoved,
    PlaceReleased,
    PlaceRequested,
    SettingsChanged,
)
from engine.master.master import Master
from engine.master.orders import Leave, Order, Start, UseMap
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.errors import Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import HOUSE, robot_config

PLACE = "robot:ann/tb1"
DOWN = PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1"))
LOFT = MapVersion("loft", "v1")
UP = PlaceRequest("ann", LOFT, 1.0, msgspec.structs.replace(robot_config("tb1"), initial_pose=(4.0, 2.0, 0.0)))
GONE = Unavailable("it exited")


@pytest.fixture
def master() -> Master:
    """Return a master whose only machine has room for one container."""
    made = Master(SameMap(), Quotas(Quota(cores=1.0, containers=1)))
    made.handle(joined("m1", 1, memory=8 << 30))
    return made


def opened(master: Master) -> str:
    [start] = master.handle(PlaceRequested(DOWN))
    assert isinstance(start, Start)
    return start.spec.id


def ready(master: Master) -> str:
    container = opened(master)
    assert master.handle(ContainerReady(container, 77)) == []
    return container


def started(orders: list[Order]) -> tuple[MapVersion, str]:
    [start] = orders
    assert isinstance(start, Start)
    return start.spec.map, start.spec.session


def test_the_container_leaves_and_the_next_takes_its_room_on_the_other_map(master: Master) -> None:
    container = ready(master)
    assert master.handle(PlaceMoved(UP)) == [Leave(PLACE, "m1", container)]
    assert master.is_leaving(container) and master.request_of(PLACE) == UP
    assert master.handle(PlaceMoved(UP)) == []
    [start] = master.handle(ContainerLost(container, GONE, 100.0))
    assert isinstance(start, Start)
    assert (start.delay, start.spec.map, start.spec.session) == (0.0, LOFT, container)
    assert start.spec.robot == UP.robot
    assert master.handle(ContainerReady(start.spec.id, 78)) == []
    [order] = master.handle(MapChanged(MapVersion("loft", "v2"), number=1))
    assert isinstance(order, UseMap) and master.handle(MapChanged(MapVersion("house", "v2"), number=1)) == []
    master.handle(PlaceReleased(PLACE))
    assert master.machines["m1"].given == 0.0


def test_a_container_that_is_starting_leaves_when_it_is_ready(master: Master) -> None:
    container = opened(master)
    master.handle(MapChanged(MapVersion("house", "v2"), number=1))
    assert master.handle(PlaceMoved(UP)) == []
    assert master.handle(ContainerReady(container, 77)) == [Leave(PLACE, "m1", container)]
    assert started(master.handle(ContainerLost(container, GONE, 100.0))) == (LOFT, container)


def test_a_container_that_dies_before_it_leaves_is_replaced_on_the_other_map(master: Master) -> None:
    container = opened(master)
    master.handle(PlaceMoved(UP))
    assert started(master.handle(ContainerLost(container, GONE, 100.0))) == (LOFT, container)


def test_a_robot_whose_machine_is_lost_meanwhile_goes_on_on_another(master: Master) -> None:
    container = ready(master)
    master.handle(PlaceMoved(UP))
    assert master.handle(MachineLeft("m1")) == []
    assert started(master.handle(joined("m2", 1, memory=8 << 30))) == (LOFT, container)


def test_a_robot_that_goes_on_before_the_first_has_left_starts_where_it_was_brought_last(master: Master) -> None:
    container = ready(master)
    master.handle(PlaceMoved(UP))
    roof = MapVersion("roof", "v1")
    last = PlaceRequest("ann", roof, 1.0, UP.robot)
    assert master.handle(PlaceMoved(last)) == []
    assert started(master.handle(ContainerLost(container, GONE, 100.0))) == (roof, container)


def test_a_place_that_moves_to_another_machine_starts_there_on_the_other_map() -> None:
    master = Master(SameMap(), Quotas(Quota(cores=2.0, containers=2)))
    master.handle(joined("m1", 1, memory=8 << 30))
    container = ready(master)
    master.handle(joined("m2", 1, memory=8 << 30))
    assert master.handle(SettingsChanged("m1", MachineSettings(draining=True))) == [Leave(PLACE, "m1", container)]
    assert master.handle(PlaceMoved(UP)) == []
    [start] = master.handle(ContainerLost(container, GONE, 100.0))
    assert isinstance(start, Start) and (start.machine, start.spec.map) == ("m2", LOFT)
    assert master.machines["m2"].containers[start.spec.id].map == LOFT
    master.handle(PlaceReleased(PLACE))
    assert master.machines["m2"].given == 0.0


def test_a_place_in_the_queue_opens_on_the_other_map_and_one_that_is_closed_stays_so(master: Master) -> None:
    master.handle(PlaceRequested(PlaceRequest("ann", HOUSE, 1.0, robot_config("tb2"))))
    master.handle(PlaceRequested(DOWN, queue=True))
    assert master.handle(PlaceMoved(UP)) == []
    orders = master.handle(PlaceReleased("robot:ann/tb2"))
    assert [order.spec.map for order in orders if isinstance(order, Start)] == [LOFT]
    master.handle(PlaceReleased(PLACE))
    assert master.handle(PlaceMoved(DOWN)) == [] and master.request_of(PLACE) is None
