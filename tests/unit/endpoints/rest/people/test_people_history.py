"""History of people over REST."""

import httpx
import pytest

from endpoints.resources.services import Services
from ppaas.messages.people_coordination import ZoneCount
from ppaas.people.settings import CountingZone, PeopleSettings
from storage.people import HOUR, MapPeople, PeopleCount
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.people import add_group
from tests.unit.endpoints.conftest import LogIn, Publish

HISTORY = "/v1/maps/house/people/history"
DOOR = CountingZone("door", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
NOW = 500_000 * HOUR
"""Start of the current hour [s since the epoch]."""


@pytest.fixture(autouse=True)
def _within_an_hour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no hour end during a test."""
    for module in ("endpoints.rest.people.people_history", "endpoints.people.settings"):
        monkeypatch.setattr(f"{module}.epoch", lambda: NOW + 0.5 * HOUR)


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish, services: Services) -> dict[str, str]:
    """Return the header of a user whose robots count people, and did so for five hours."""
    header = await log_in("ann")
    await publish(header)
    settings = PeopleSettings(history=True, zones=[DOOR], retention_hours=3.0)
    services.store.put_people_settings(MapPeople("ann", "house", settings))
    rows = [PeopleCount("ann", "house", NOW - ago * HOUR, zone, ago) for ago in range(1, 6) for zone in ("", "door")]
    services.store.add_people_counts(rows)
    return header


async def listed(client: httpx.AsyncClient, header: dict[str, str], **query: object) -> list[tuple[int, str, int]]:
    """Return the hours before the current one, the zones and the numbers of people, from all pages."""
    found, cursor = [], None
    while True:
        given = {"limit": 3, **query} | ({} if cursor is None else {"cursor": cursor})
        answer = (await client.get(HISTORY, headers=header, params=given)).json()
        found += [((NOW - row["hour"]) // HOUR, row["zone"], row["people"]) for row in answer["items"]]
        cursor = answer["next"]
        if cursor is None:
            return found


async def test_counts_are_listed_by_hour_and_zone_without_expired_ones(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    assert await listed(client, ann) == [(ago, zone, ago) for ago in (3, 2, 1) for zone in ("", "door")]
    assert await listed(client, ann, zone="door") == [(3, "door", 3), (2, "door", 2), (1, "door", 1)]
    assert await listed(client, ann, zone="", since=NOW - 2 * HOUR) == [(2, "", 2), (1, "", 1)]
    assert await listed(client, ann, zone="", until=NOW - 2 * HOUR) == [(3, "", 3)]


async def test_the_list_has_the_current_hour_so_far(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.zone_counts["ann", "house"] = [ZoneCount("", NOW, 7)]
    assert await listed(client, ann, since=NOW) == [(0, "", 7)]


async def test_removed_counts_do_not_come_back(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, services: Services
) -> None:
    add_group(cloud, "ann", "house")
    cloud.zone_counts["ann", "house"] = [ZoneCount("", NOW, 7)]
    assert (await client.delete(HISTORY, headers=ann)).status_code == 204
    assert await listed(client, ann) == []
    assert cloud.people_settings["ann", "house"][-1] == services.store.map_people("ann", "house").settings
    assert services.store.map_people("ann", "house").settings.history


async def test_a_shorter_retention_removes_older_counts_at_once(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services
) -> None:
    path = "/v1/maps/house/people/settings"
    assert (await client.patch(path, headers=ann, json={"retention_hours": 1})).status_code == 200
    assert {row.hour for row in services.store.people_counts("ann", "house")} == {NOW - HOUR}


async def test_counts_of_other_users_are_not_listed(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str]
) -> None:
    assert await listed(client, await log_in("admin")) == []


@pytest.mark.parametrize("query", [{"since": "nan"}, {"until": -1}, {"zone": "x" * 65}, {"hour": 1}, {"cursor": "x"}])
async def test_invalid_queries_are_refused(
    client: httpx.AsyncClient, ann: dict[str, str], query: dict[str, object]
) -> None:
    assert (await client.get(HISTORY, headers=ann, params=query)).status_code == 422
