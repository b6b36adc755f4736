"""Places follow the current versions of their maps and masks."""

import pytest

from engine.master import state
from engine.master.balancers.ppaas import SameMap
from engine.master.events import ContainerLost, ContainerReady, MapChanged, PlaceReleased, PlaceRequested, RobotTimed
from engine.master.master import Master
from engine.master.orders import Order, Start, UseMap
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.specs.containers import GroupNode, MapVersion
from ppaas.errors import Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import HOUSE, robot_config

NEXT = MapVersion(HOUSE.id, "v2")
PLACE = "robot:ann/tb1"


@pytest.fixture
def master() -> Master:
    made = Master(SameMap(), Quotas(Quota(cores=1.0)))
    made.handle(joined("m1", 2, memory=8 << 30))
    return made


def opened(master: Master, request: PlaceRequest | None = None) -> str:
    [start] = master.handle(PlaceRequested(request or PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1"))))
    assert isinstance(start, Start)
    return start.spec.id


def ready(master: Master, request: PlaceRequest | None = None) -> str:
    container = opened(master, request)
    assert master.handle(ContainerReady(container, 77)) == []
    return container


def maps_of(orders: list[Order]) -> list[tuple[str, MapVersion]]:
    return [(order.spec.id, order.spec.map) for order in orders if isinstance(order, UseMap | Start)]


def test_a_robot_on_the_map_follows_and_so_does_its_next_container(master: Master) -> None:
    container = ready(master)
    master.handle(RobotTimed(PLACE, 0.5))
    assert maps_of(master.handle(MapChanged(NEXT, in_space=True))) == [(container, NEXT)]
    machine = master.machines["m1"]
    assert (machine.given, machine.served, machine.containers[container].map) == (1.0, {container: 0.5}, NEXT)
    request = master.request_of(PLACE)
    assert request is not None and request.robot is not None
    assert (request.map, request.robot.in_space) == (NEXT, True)
    [start] = master.handle(ContainerLost(container, Unavailable("boom"), 100.0))
    assert isinstance(start, Start) and start.spec.map == NEXT
    assert master.handle(ContainerReady(start.spec.id, 78)) == []
    master.handle(PlaceReleased(PLACE))
    assert machine.given == 0.0


def test_a_container_that_is_starting_gets_its_order_when_it_is_ready(master: Master) -> None:
    container = opened(master)
    assert master.handle(MapChanged(NEXT)) == []
    assert maps_of(master.handle(ContainerReady(container, 77))) == [(container, NEXT)]
    assert master.handle(ContainerReady(container, 77)) == []


def test_robots_on_other_maps_planning_and_mapping_robots_do_not_follow(master: Master) -> None:
    ready(master, PlaceRequest("ann", HOUSE, 0.25))
    ready(master, PlaceRequest("ann", MapVersion("depot", "v1"), 0.25, robot_config("tb2")))
    ready(master, PlaceRequest("ann", MapVersion("new:house", ""), 0.25, robot_config("tb3", new_map="house")))
    assert master.handle(MapChanged(NEXT)) == []


@pytest.mark.parametrize("node", ["people", "traffic"])
def test_the_node_of_a_group_follows_its_map_and_so_does_its_next_container(master: Master, node: GroupNode) -> None:
    container = ready(master, PlaceRequest("ann", HOUSE, 0.25, group_node=node))
    assert maps_of(master.handle(MapChanged(NEXT))) == [(container, NEXT)]
    assert master.handle(MapChanged(MapVersion("depot", "v9"))) == []
    [start] = master.handle(ContainerLost(container, Unavailable("boom"), 100.0))
    assert isinstance(start, Start) and (start.spec.map, start.spec.group_node) == (NEXT, node)
    assert (start.place, start.spec.session) == (f"{node}:ann/house", container)


def test_the_current_version_again_orders_nothing(master: Master) -> None:
    ready(master)
    assert master.handle(MapChanged(HOUSE)) == []


def test_a_version_that_was_read_before_a_later_one_was_published_is_not_used(master: Master) -> None:
    container = ready(master)
    last = MapVersion(HOUSE.id, "v3")
    assert maps_of(master.handle(MapChanged(last, number=7))) == [(container, last)]
    assert master.handle(MapChanged(NEXT, number=6)) == []
    request = master.request_of(PLACE)
    assert request is not None and request.map == last
    rolled_back = master.handle(MapChanged(NEXT, number=8))
    assert maps_of(rolled_back) == [(container, NEXT)]


def test_a_place_opens_with_the_version_that_was_published_after_its_request_was_read(master: Master) -> None:
    masks = {"keepout_filter": MapVersion("zones", "v1")}
    master.handle(MapChanged(NEXT, in_space=True, number=2))
    master.handle(MapChanged(MapVersion("zones", "v2"), number=5))
    opened(master, PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1", masks=masks)))
    request = master.request_of(PLACE)
    assert request is not None and request.robot is not None
    assert (request.map, request.robot.in_space) == (NEXT, True)
    assert request.robot.masks == {"keepout_filter": MapVersion("zones", "v2")}


def test_the_versions_of_the_maps_that_changed_last_are_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state, "MOST_KNOWN", 2)
    versions = state.CurrentVersions()
    for name in ("house", "depot", "house", "office"):
        assert versions.note(MapChanged(MapVersion(name, "v2"), number=1))
    found = [
        versions.of(PlaceRequest("ann", MapVersion(name, "v1"), 1.0, robot_config("tb1"))).map.version
        for name in ("house", "depot", "office")
    ]
    assert found == ["v2", "v1", "v2"]


def test_masks_follow_too(master: Master) -> None:
    masks = {"keepout_filter": MapVersion("zones", "v1"), "speed_filter": MapVersion("speeds", "v1")}
    ready(master, PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1", masks=masks)))
    [order] = master.handle(MapChanged(MapVersion("zones", "v2")))
    assert isinstance(order, UseMap) and order.spec.robot is not None
    assert order.spec.map == HOUSE
    assert order.spec.robot.masks == masks | {"keepout_filter": MapVersion("zones", "v2")}


def test_queued_requests_follow(master: Master) -> None:
    ready(master, PlaceRequest("ann", MapVersion("depot", "v1"), 1.0, robot_config("tb2")))
    master.handle(PlaceRequested(PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1")), queue=True))
    assert master.handle(MapChanged(NEXT)) == []
    assert maps_of(master.handle(PlaceReleased("robot:ann/tb2")))[0][1] == NEXT


def test_a_robot_in_space_stays_there_if_its_map_changed_as_the_mask_of_another(master: Master) -> None:
    ready(master, PlaceRequest("ann", HOUSE, 1.0, robot_config("tb1", in_space=True)))
    [order] = master.handle(MapChanged(NEXT, in_space=None))
    assert isinstance(order, UseMap) and order.spec.robot is not None
    assert (order.spec.map, order.spec.robot.in_space) == (NEXT, True)
