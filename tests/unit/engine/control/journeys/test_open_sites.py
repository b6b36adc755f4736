"""Sites are open while robots travel there, and a while after that or after somebody has looked."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from engine.control.journeys import open_sites
from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.open_sites import FRESH, LINGER, OpenSites
from engine.control.journeys.site import JourneySite, SiteHooks
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.building import Building, Floor
from ppaas.buildings.layout import BuildingLayout
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.maps import MemoryMapStore
from tests.support.storage import records
from tests.support.waiting import until
from tests.unit.engine.control.journeys.test_site import JOURNEY, Around


class Town:
    """Open sites, with the number of those that were made and a clock that the test sets."""

    def __init__(self) -> None:
        self.maps, self.made, self.now = MemoryMapStore(), 0, 1000.0
        self.around = Around()
        self.around.robot.reaches = False
        records.put_map(self.maps, records.house("m1"))
        self.sites = OpenSites(self.maps, lambda _key: KeptJourneys(), self.make, lambda: self.now)

    def make(self, record: BuildingRecord, layout: BuildingLayout, kept: KeptJourneys) -> JourneySite:
        self.made += 1
        hooks = SiteHooks(
            self.around.rider, self.around.plan, self.around.keep, self.around.changes.append, self.around.parts
        )
        return JourneySite("/".join(record.key), layout, hooks, DeviceHosts(), kept=kept)


def building(name: str = "hotel", number: int = 1) -> BuildingRecord:
    made = Building(floors=(Floor(name="L1", map="m1"), Floor(name="L2", map="gone")))
    return BuildingRecord(
        user="ann", id=name, present=BuildingVersion(number=number, building=made, author="ann", created=1.0)
    )


@pytest.fixture
async def town() -> AsyncIterator[Town]:
    made = Town()
    yield made
    await made.sites.close()


async def test_a_site_that_nobody_needs_is_closed_after_a_while_and_opened_again(town: Town) -> None:
    site = await town.sites.look(building())
    town.now += LINGER
    await town.sites.close_idle()
    assert town.sites.get(("ann", "hotel")) is site
    town.now += 1.0
    await town.sites.close_idle()
    assert town.sites.get(("ann", "hotel")) is None and list(town.sites) == []
    assert await town.sites.look(building()) is not site
    assert town.made == 2


async def test_a_look_keeps_a_site_open(town: Town) -> None:
    site = await town.sites.look(building())
    for _ in range(3):
        town.now += LINGER - 1.0
        assert await town.sites.look(building()) is site
        await town.sites.close_idle()
    assert town.made == 1


async def test_a_site_stays_open_while_a_robot_travels_and_a_while_longer(town: Town) -> None:
    site = await town.sites.site(building())
    site.begin(JOURNEY)
    await until(lambda: bool(town.around.changes))
    town.now += 100.0 * LINGER
    await town.sites.close_idle()
    assert town.sites.get(("ann", "hotel")) is site
    site.cancel(JOURNEY)
    await until(lambda: site.is_idle)
    town.now += LINGER - 1.0
    await town.sites.close_idle()
    assert town.sites.get(("ann", "hotel")) is site, "counted from the last time at which it was needed"
    town.now += 2.0
    await town.sites.close_idle()
    assert town.sites.get(("ann", "hotel")) is None


async def test_of_too_many_idle_sites_those_used_longest_ago_are_closed(
    town: Town, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(open_sites, "MOST_IDLE", 2)
    for name in ("one", "two", "three"):
        town.now += 1.0
        await town.sites.look(building(name))
    await town.sites.close_idle()
    assert [town.sites.get(("ann", name)) is None for name in ("one", "two", "three")] == [True, False, False]


async def test_a_changed_building_or_map_is_read_again_by_those_who_look(town: Town) -> None:
    site = await town.sites.look(building())
    newer = await town.sites.look(building(number=2))
    assert newer is not site
    records.put_map(town.maps, records.house("m1", image=records.pgm(value=0)))
    assert await town.sites.look(building(number=2)) is newer, "the maps were looked at a moment ago"
    town.now += FRESH + 1.0
    assert await town.sites.look(building(number=2)) is not newer


async def test_running_sites_are_closed_at_the_end(town: Town, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(open_sites, "TICK", 0.01)
    await town.sites.look(building())
    running = asyncio.create_task(town.sites.run())
    town.now += LINGER + 1.0
    await until(lambda: not list(town.sites))
    await town.sites.look(building())
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    assert list(town.sites) == []
