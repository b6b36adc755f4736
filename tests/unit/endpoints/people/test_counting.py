"""Counting of people: collection, and removal of expired counts."""

import logging

import pytest

from endpoints.people.counting import PeopleCounting
from endpoints.resources.services import Services
from engine.control.views import PeopleGroupView
from ppaas.messages.people_coordination import ZoneCount
from ppaas.people.settings import CountingZone, PeopleSettings
from storage.people import HOUR, MapPeople
from tests.support.endpoints.fake_cloud import FakeCloud

DOOR = CountingZone("door", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
NOW = 1000.5 * HOUR
ANN = ("ann", "house")


def counts(services: Services, user: str = "ann") -> list[tuple[int, str, int]]:
    return [(row.hour // HOUR, row.zone, row.people) for row in services.store.people_counts(user, "house")]


def put(services: Services, **settings: object) -> None:
    services.store.put_people_settings(MapPeople(*ANN, PeopleSettings(**settings)))  # type: ignore[arg-type]


@pytest.fixture
def counting(services: Services, cloud: FakeCloud) -> PeopleCounting:
    cloud.groups.append(PeopleGroupView(*ANN, ("tb1",), "ready"))
    return PeopleCounting(services, lambda: NOW)


async def test_nothing_is_stored_unless_history_is_on(
    counting: PeopleCounting, services: Services, cloud: FakeCloud
) -> None:
    cloud.zone_counts[ANN] = [ZoneCount("", 1000 * HOUR, 3)]
    await counting.step()
    put(services)
    await counting.step()
    assert counts(services) == []


async def test_counts_that_are_collected_again_count_once(
    counting: PeopleCounting, services: Services, cloud: FakeCloud
) -> None:
    put(services, history=True, zones=[DOOR])
    cloud.zone_counts[ANN] = [
        ZoneCount("", 999 * HOUR, 8),
        ZoneCount("", 1000 * HOUR, 3),
        ZoneCount("door", 1000 * HOUR, 1),
    ]
    await counting.step()
    cloud.zone_counts[ANN][1] = ZoneCount("", 1000 * HOUR, 4)
    await counting.step()
    await PeopleCounting(services, lambda: NOW).step()
    assert counts(services) == [(999, "", 8), (1000, "", 4), (1000, "door", 1)]


async def test_a_coordinator_that_starts_anew_does_not_lower_counts(
    counting: PeopleCounting, services: Services, cloud: FakeCloud
) -> None:
    put(services, history=True)
    for people in (5, 1):
        cloud.zone_counts[ANN] = [ZoneCount("", 1000 * HOUR, people)]
        await counting.step()
    assert counts(services) == [(1000, "", 5)]


async def test_counts_of_unknown_zones_and_expired_hours_are_not_stored(
    counting: PeopleCounting, services: Services, cloud: FakeCloud
) -> None:
    put(services, history=True, zones=[DOOR], retention_hours=2.0)
    hours = (997, 998, 1000)
    cloud.zone_counts[ANN] = [ZoneCount(zone, hour * HOUR, 1) for hour in hours for zone in ("door", "attic")]
    await counting.step()
    assert counts(services) == [(998, "door", 1), (1000, "door", 1)]


async def test_expired_counts_are_removed_also_without_robots(services: Services, cloud: FakeCloud) -> None:
    put(services, history=True, retention_hours=2.0)
    cloud.groups.append(PeopleGroupView(*ANN, ("tb1",), "ready"))
    cloud.zone_counts[ANN] = [ZoneCount("", 1000 * HOUR, 3)]
    now = NOW
    counting = PeopleCounting(services, lambda: now)
    await counting.step()
    cloud.groups.clear()
    now += 2 * HOUR
    await counting.step()
    assert counts(services) == [(1000, "", 3)]
    now += HOUR
    await counting.step()
    assert counts(services) == []


async def test_a_group_that_does_not_answer_is_reported_once_and_does_not_stop_others(
    counting: PeopleCounting, services: Services, cloud: FakeCloud, caplog: pytest.LogCaptureFixture
) -> None:
    put(services, history=True)
    services.store.put_people_settings(MapPeople("bob", "house", PeopleSettings(history=True)))
    cloud.groups.append(PeopleGroupView("bob", "house", ("tb1",), "ready"))
    cloud.zone_counts["bob", "house"] = [ZoneCount("", 1000 * HOUR, 2)]
    with caplog.at_level(logging.WARNING):
        await counting.step()
        await counting.step()
    assert counts(services, "bob") == [(1000, "", 2)]
    assert len([record for record in caplog.records if "'house'" in record.getMessage()]) == 1
