"""People on a map over REST: state, settings, and whom to follow."""

import httpx
import pytest

from endpoints.resources.services import Services
from engine.control.views import PeopleGroupView
from ppaas.errors import InvalidInput, NotFound, Unavailable
from ppaas.people.names import coordinator_checkpoint
from ppaas.people.settings import PeopleSettings
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.people import add_group, person
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import clone
from tests.unit.endpoints.conftest import LogIn, Publish

PEOPLE = "/v1/maps/house/people"
SETTINGS = f"{PEOPLE}/settings"
ZONE = {"name": "door", "corners": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]}


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Return the header of a user who has published a map for all."""
    header = await log_in("ann")
    await publish(header, readers="*")
    return header


async def test_people_are_shown_with_who_follows_whom_and_why(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    add_group(cloud, "ann", "house", person(1, name="Zoë"), person(2, x=4.0, state="predicted"))
    answer = (await client.get(PEOPLE, headers=ann)).json()
    assert (answer["coordinator"], answer["count"], answer["at"], answer["rule"]) == ("ready", 2, 100.5, "nearest")
    assert answer["rules"] == ["longest_seen", "named", "nearest"]
    first, second = answer["people"]
    assert (first["id"], first["name"], first["position"], first["velocity"]) == (1, "Zoë", [1.0, 2.0], [0.5, 0.0])
    assert (first["first_seen"], first["last_seen"], first["seen_by"]) == (90.0, 100.0, ["tb1/4"])
    assert second["state"] == "predicted"
    assert answer["following"] == [{"robot": "tb1", "person": 1, "cost": 3.5, "since": 95.0, "reason": "nearest"}]
    reported, silent = answer["robots"]
    assert (reported["robot"], reported["position"], reported["deviation"]) == ("tb1", [0.0, 2.0], 0.2)
    assert (silent["robot"], silent["position"], silent["deviation"]) == ("tb2", None, None)


async def test_a_map_without_robots_that_track_people_shows_nobody(
    client: httpx.AsyncClient, ann: dict[str, str]
) -> None:
    answer = (await client.get(PEOPLE, headers=ann)).json()
    assert (answer["coordinator"], answer["count"], answer["people"], answer["robots"]) == ("none", 0, [], [])
    assert "no robot" in answer["reason"]


async def test_a_refused_coordinator_shows_the_reason_and_the_robots(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    cloud.groups.append(PeopleGroupView("ann", "house", ("tb1",), "refused", "user 'ann' may have 64 containers"))
    answer = (await client.get(PEOPLE, headers=ann)).json()
    assert (answer["coordinator"], answer["reason"]) == ("refused", "user 'ann' may have 64 containers")
    assert [robot["robot"] for robot in answer["robots"]] == ["tb1"]


async def test_a_coordinator_that_does_not_answer_is_shown_as_starting(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud
) -> None:
    add_group(cloud, "ann", "house", person(1))
    cloud.error = Unavailable("the container was lost")
    answer = (await client.get(PEOPLE, headers=ann)).json()
    assert (answer["coordinator"], answer["reason"], answer["at"]) == ("starting", "the container was lost", None)


@pytest.mark.parametrize("user", ["bob", "admin"])
async def test_people_of_other_users_robots_are_shown_to_nobody_else(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str], cloud: FakeCloud, user: str
) -> None:
    add_group(cloud, "ann", "house", person(1))
    await client.patch(SETTINGS, headers=ann, json={"names": {"1": "Zoë"}})
    other = await log_in(user)
    assert (await client.get(PEOPLE, headers=other)).json()["people"] == []
    assert (await client.get(SETTINGS, headers=other)).json()["names"] == {}
    problem_of(await client.post(f"{PEOPLE}/follow", headers=other, json={"people": [1]}), 503, "unavailable")
    assert ("ann", "house") in cloud.people_settings and (user, "house") not in cloud.people_settings


async def test_a_map_that_may_not_be_read_is_unknown(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    await publish(await log_in("ann"))
    bob = await log_in("bob")
    for path in (PEOPLE, SETTINGS, f"{PEOPLE}/history"):
        problem_of(await client.get(path, headers=bob), 404, "not-found")
    problem_of(await client.put(SETTINGS, headers=bob, json={}), 404, "not-found")


async def test_settings_are_off_by_default_and_reach_the_coordinator_when_changed(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, services: Services
) -> None:
    first = (await client.get(SETTINGS, headers=ann)).json()
    assert (first["history"], first["rule"], first["retention_hours"]) == (False, "nearest", 720.0)
    put = await client.put(SETTINGS, headers=ann, json={"rule": "longest_seen", "zones": [ZONE], "history": True})
    assert (put.status_code, put.json()["zones"]) == (200, [ZONE])
    patch = {"names": {"3": "Zoë", "4": "Max"}, "rule": None}
    changed = await client.patch(SETTINGS, headers=ann, json=patch)
    assert (changed.json()["rule"], changed.json()["names"]) == ("nearest", {"3": "Zoë", "4": "Max"})
    changed = await client.patch(SETTINGS, headers=ann, json={"names": {"3": None}})
    assert (changed.json()["names"], changed.json()["history"]) == ({"4": "Max"}, True)
    assert cloud.people_settings["ann", "house"][-1] == services.store.map_people("ann", "house").settings
    assert len(cloud.people_settings["ann", "house"]) == 3


@pytest.mark.parametrize(
    "settings",
    [
        {"targets": [0]},
        {"targets": ["1"]},
        {"followed_at_once": 1.5},
        {"names": {"Zoë": "1"}},
        {"names": {"1": ""}},
        {"zones": [ZONE | {"corners": [[0, 0], [1, 1]]}]},
        {"zones": [ZONE | {"corners": [[0, 0], [1, 1], [1e10, 0]]}]},
        {"zones": [ZONE | {"corners": [[0, 0], [2, 2], [2, 0], [0, 2]]}]},
        {"zones": [ZONE | {"name": ""}]},
        {"zones": [ZONE, ZONE]},
        {"history": "yes"},
        {"retention_hours": 0},
        {"retention_hours": 1e6},
        {"camera": True},
    ],
    ids=str,
)
async def test_invalid_settings_are_refused_and_change_nothing(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud, settings: dict[str, object]
) -> None:
    for send in (client.put, client.patch):
        assert (await send(SETTINGS, headers=ann, json=settings)).status_code in (400, 422)
    assert (services.store.people_maps(), cloud.people_settings) == ([], {})


async def test_unknown_rules_and_settings_that_the_coordinator_refuses_are_not_kept(
    client: httpx.AsyncClient, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    await client.put(SETTINGS, headers=ann, json={"rule": "longest_seen"})
    unknown = await client.patch(SETTINGS, headers=ann, json={"rule": "tallest"})
    assert "known: longest_seen, named, nearest" in problem_of(unknown, 422, "invalid-parameter")["detail"]
    cloud.error = InvalidInput("the container has another release")
    refused = await client.patch(SETTINGS, headers=ann, json={"rule": "named"})
    problem_of(refused, 400, "invalid-input")
    assert services.store.map_people("ann", "house").settings.rule == "longest_seen"


async def test_a_person_is_followed_by_id_or_by_name(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, services: Services
) -> None:
    add_group(cloud, "ann", "house", person(1), person(3))
    await client.patch(SETTINGS, headers=ann, json={"names": {"3": "Zoë"}})
    answer = (await client.post(f"{PEOPLE}/follow", headers=ann, json={"people": ["Zoë", 1, 3]})).json()
    assert (answer["rule"], answer["targets"], answer["followed_at_once"]) == ("named", [3, 1], 2)
    assert cloud.people_settings["ann", "house"][-1] == services.store.map_people("ann", "house").settings
    nobody = (await client.post(f"{PEOPLE}/follow", headers=ann, json={"people": []})).json()
    assert (nobody["rule"], nobody["targets"], nobody["names"]) == ("named", [], {"3": "Zoë"})


async def test_people_whom_nobody_sees_cannot_be_followed(
    client: httpx.AsyncClient, ann: dict[str, str], cloud: FakeCloud, services: Services
) -> None:
    add_group(cloud, "ann", "house", person(1))
    for wanted in (7, "Zoë"):
        answer = await client.post(f"{PEOPLE}/follow", headers=ann, json={"people": [wanted]})
        assert str(wanted) in problem_of(answer, 404, "not-found")["detail"]
    await client.patch(SETTINGS, headers=ann, json={"names": {"1": "Max", "2": "Max"}})
    answer = await client.post(f"{PEOPLE}/follow", headers=ann, json={"people": ["Max"]})
    assert "give an id: [1, 2]" in problem_of(answer, 422, "invalid-parameter")["detail"]
    assert services.store.map_people("ann", "house").settings == PeopleSettings(names={"1": "Max", "2": "Max"})


async def test_settings_and_counts_go_with_their_map(
    client: httpx.AsyncClient, log_in: LogIn, ann: dict[str, str], services: Services, cloud: FakeCloud
) -> None:
    await client.put(SETTINGS, headers=ann, json={"history": True})
    await log_in("bob")
    for user in ("ann", "bob"):
        services.store.save_clone(clone(coordinator_checkpoint("house"), user=user))
    assert (await client.delete("/v1/maps/house", headers=ann)).status_code == 204
    assert (services.store.people_maps(), cloud.maps_without_groups) == ([], ["house"])
    for user in ("ann", "bob"):
        with pytest.raises(NotFound):
            services.store.clone(user, coordinator_checkpoint("house"))
