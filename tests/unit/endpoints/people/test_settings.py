"""Changes of the settings of people: several at once, and the coordinator's part."""

import asyncio

import pytest
from msgspec.structs import replace

from endpoints.people.counting import collect_counts
from endpoints.people.settings import Change, change_settings, forget_counts
from endpoints.resources.services import Services
from ppaas.errors import NotFound, Unavailable
from ppaas.messages.people_coordination import ZoneCount
from ppaas.people.settings import PeopleSettings
from storage.people import HOUR, MapPeople, PeopleCount
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.people import add_group

ANN = ("ann", "house")


def naming(person: int) -> Change:
    return lambda settings: replace(settings, names=settings.names | {str(person): f"person {person}"})


async def test_changes_at_once_lose_nothing_and_the_coordinator_has_them_all(
    services: Services, cloud: FakeCloud
) -> None:
    await asyncio.gather(*(change_settings(services, *ANN, naming(person)) for person in range(1, 5)))
    settings = services.store.map_people(*ANN).settings
    assert sorted(settings.names) == ["1", "2", "3", "4"]
    assert cloud.people_settings[ANN][-1] == settings


async def test_settings_that_are_refused_are_replaced_by_the_ones_before(
    services: Services, cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def refuse(*_: object) -> None:
        raise NotFound("rule", "named")

    await change_settings(services, *ANN, naming(1))
    monkeypatch.setattr(cloud.people, "configure", refuse)
    with pytest.raises(NotFound):
        await change_settings(services, *ANN, lambda settings: replace(settings, rule="named"))
    assert services.store.map_people(*ANN).settings.names == {"1": "person 1"}


async def test_counts_are_removed_also_if_the_coordinator_does_not_answer(
    services: Services, cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def silent(*_: object) -> None:
        raise Unavailable("the container was lost")

    services.store.put_people_settings(MapPeople(*ANN, PeopleSettings(history=True)))
    services.store.add_people_counts([PeopleCount(*ANN, HOUR, "", 3)])
    monkeypatch.setattr(cloud.people, "configure", silent)
    add_group(cloud, *ANN)
    with pytest.raises(Unavailable):
        await forget_counts(services, *ANN)
    assert services.store.people_counts(*ANN) == []


async def test_counts_in_the_checkpoint_of_a_coordinator_that_does_not_run_do_not_come_back(
    services: Services, cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("endpoints.people.settings.epoch", lambda: 9.5 * HOUR)
    services.store.put_people_settings(MapPeople(*ANN, PeopleSettings(history=True)))
    await forget_counts(services, *ANN)
    await change_settings(services, *ANN, naming(1))
    cloud.zone_counts[ANN] = [ZoneCount("", hour * HOUR, 3) for hour in (8, 9, 10)]
    assert await collect_counts(services, *ANN, 10.2 * HOUR)
    assert services.store.people_counts(*ANN) == [PeopleCount(*ANN, 10 * HOUR, "", 3)]


async def test_the_coordinator_forgets_its_counts_and_goes_on_counting(services: Services, cloud: FakeCloud) -> None:
    add_group(cloud, *ANN)
    settings = PeopleSettings(history=True)
    services.store.put_people_settings(MapPeople(*ANN, settings))
    cloud.zone_counts[ANN] = [ZoneCount("", HOUR, 3)]
    await forget_counts(services, *ANN)
    assert ANN not in cloud.zone_counts
    assert cloud.people_settings[ANN] == [replace(settings, history=False), settings]
