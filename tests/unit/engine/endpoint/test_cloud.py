"""An endpoint asks the master for a planning container once, and then from time to time."""

from typing import Any

import pytest

from engine.endpoint.cloud import KEEP, EndpointCloud
from engine.endpoint.places import EndpointPlaces
from engine.master.quotas import Quota, Quotas
from engine.service.endpoints.interface import JoinedPlace
from engine.specs.containers import MapVersion
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable

VERSION = MapVersion("office", "v1")
KEY = "planning:ann/office"


class Master:
    """Master that opens planning places, or has none free."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []
        self.position: int | None = None

    async def call(self, method: object, *arguments: Any) -> JoinedPlace:
        self.asked.append(arguments)
        return JoinedPlace(KEY, "base_link", self.position)


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
