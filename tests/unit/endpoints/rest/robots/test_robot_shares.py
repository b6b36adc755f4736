"""Sharing of robots over REST."""

from typing import Any

import httpx
import numpy as np
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from endpoints.rest.robots.robot_shares import MAX_SHARES
from ppaas.clock import epoch
from ppaas.geometry import poses_along
from storage.sharing_records import Share
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.still_place import StillRobot
from tests.support.storage import records
from tests.unit.endpoints.conftest import LogIn, Publish

SHARES = "/v1/robots/tb1/shares"
POSES = poses_along(np.stack((np.arange(60) * 0.05, np.zeros(60)), axis=1), 0.0).tobytes()
ENDS = {"map": "house", "start": "0,0", "goal": "2.95,0"}
Header = dict[str, str]


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> Header:
    """Return the header of a user with a private map and a robot on it."""
    header = await log_in("ann")
    await publish(header)
    assert (await client.put("/v1/robots/tb1", headers=header, json={"map": "house"})).status_code == 201
    return header


@pytest.fixture(autouse=True)
def _members(services: Services) -> None:
    """Keep the group ``hall`` alive."""
    services.store.add_user(records.user("dora", groups=("hall",)))


@pytest.fixture
async def bob(log_in: LogIn) -> Header:
    return await log_in("bob")


async def share(client: httpx.AsyncClient, header: Header, grantee: str = "bob", **file: Any) -> httpx.Response:
    return await client.put(f"{SHARES}/{grantee}", headers=header, json=file)


async def test_shares_are_put_listed_changed_and_removed(client: httpx.AsyncClient, ann: Header, bob: Header) -> None:
    first = await share(client, ann, role="drive", publish=["/cmd_vel"])
    expected = {"to": "bob", "role": "drive", "publish": ["cmd_vel"], "subscribe": ["*"]}
    assert (first.status_code, first.json()) == (201, expected)
    assert (await share(client, ann, role="look", subscribe=["map"])).status_code == 200
    assert (await share(client, ann, "group:hall", role="administer")).status_code == 201
    listed = (await client.get(SHARES, headers=ann)).json()["items"]
    assert [(one["to"], one["role"], one["publish"]) for one in listed] == [
        ("bob", "look", []), ("group:hall", "administer", ["*"]),
    ]  # fmt: skip
    page = (await client.get(f"{SHARES}?limit=1", headers=ann)).json()
    rest = await client.get(SHARES, headers=ann, params={"cursor": page["next"]})
    assert [one["to"] for one in rest.json()["items"]] == ["group:hall"]
    assert (await client.delete(f"{SHARES}/bob", headers=ann)).status_code == 204
    problem_of(await client.delete(f"{SHARES}/bob", headers=ann), 404, "not-found")


@pytest.mark.parametrize(
    ("grantee", "file", "text"),
    [
        ("bob", {"role": "look", "publish": ["cmd_vel"]}, "role 'look' publishes nothing"),
        ("bob", {"role": "administer", "subscribe": ["map"]}, "role 'administer' has all topics"),
        ("bob", {"role": "robot"}, "Input should be 'look', 'drive' or 'administer'"),
        ("bob", {"role": "drive", "publish": ["a b"]}, "String should match pattern"),
        ("bob", {"role": "drive", "publish": ["a"] * 65}, "at most 64 items"),
        ("group:", {"role": "look"}, "give the id of a user, or 'group:' and the name of a group"),
        ("ann", {"role": "look"}, "belongs to 'ann': share it with others"),
    ],
)
async def test_invalid_shares_are_refused_with_the_reason(
    client: httpx.AsyncClient, ann: Header, grantee: str, file: dict[str, Any], text: str
) -> None:
    answer = await share(client, ann, grantee, **file)
    assert answer.status_code == 422
    assert text in answer.json()["detail"]


@pytest.mark.parametrize(
    ("grantee", "text"), [("bbo", "unknown user 'bbo'"), ("group:hal", "unknown group 'hal'"), ("hall", "user 'hall'")]
)
async def test_a_robot_is_not_shared_with_somebody_unknown(
    client: httpx.AsyncClient, ann: Header, services: Services, grantee: str, text: str
) -> None:
    refused = await share(client, ann, grantee, role="drive")
    assert text in problem_of(refused, 404, "not-found")["detail"]
    assert services.store.robot("ann", "tb1").shares == ()


async def test_a_share_with_somebody_who_was_removed_meanwhile_can_be_changed(
    client: httpx.AsyncClient, ann: Header, services: Services
) -> None:
    services.store.change_shares(services.store.robot("ann", "tb1"), (Share("gone", "drive"),))
    assert (await share(client, ann, "gone", role="look")).status_code == 200


async def test_a_robot_is_shared_with_a_bounded_number(
    client: httpx.AsyncClient, ann: Header, services: Services
) -> None:
    shares = tuple(Share(f"u{number}", "look") for number in range(MAX_SHARES))
    services.store.change_shares(services.store.robot("ann", "tb1"), shares)
    problem_of(await share(client, ann, "dora", role="look"), 422, "invalid-parameter")
    assert (await share(client, ann, "u7", role="drive")).status_code == 200
    assert len(services.store.robot("ann", "tb1").shares) == MAX_SHARES


async def test_shared_robots_are_listed_with_the_role_and_shown_by_their_address(
    client: httpx.AsyncClient, ann: Header, bob: Header
) -> None:
    for number in (3, 2):
        await client.put(f"/v1/robots/tb{number}", headers=ann, json={"map": "house"})
        await client.put(f"/v1/robots/tb{number}/shares/bob", headers=ann, json={"role": "drive"})
    await share(client, ann, role="look")
    assert (await client.get("/v1/robots", headers=bob)).json()["items"] == []
    page = (await client.get("/v1/robots?shared=true&limit=2", headers=bob)).json()
    rest = (await client.get("/v1/robots", headers=bob, params={"shared": "true", "cursor": page["next"]})).json()
    listed = [(one["user"], one["id"], one["role"]) for one in page["items"] + rest["items"]]
    assert listed == [("ann", "tb1", "look"), ("ann", "tb2", "drive"), ("ann", "tb3", "drive")]
    shown = (await client.get("/v1/robots/ann:tb1", headers=bob)).json()
    assert (shown["id"], shown["user"], shown["role"]) == ("tb1", "ann", "look")
    assert (await client.get("/v1/robots?shared=true", headers=ann)).json()["items"] == []


async def test_an_error_names_the_right_that_is_missing(client: httpx.AsyncClient, ann: Header, bob: Header) -> None:
    url = "/v1/robots/ann:tb1"
    unknown = await client.get(url, headers=bob)
    assert problem_of(unknown, 404, "not-found")["detail"] == "unknown robot 'ann:tb1'"
    await share(client, ann, role="look")
    refused = await client.post(f"{url}/goals", headers=bob, json={"pose": [1, 1]})
    text = "this needs the role 'drive' on robot 'ann:tb1'; you have 'look': ask its owner for more"
    assert problem_of(refused, 403, "not-permitted")["detail"] == text


async def test_a_driver_sends_goals_only_if_goals_are_shared(
    client: httpx.AsyncClient, ann: Header, bob: Header, cloud: FakeCloud
) -> None:
    cloud.connect("ann", "tb1", StillRobot())
    goals = "/v1/robots/ann:tb1/goals"
    await share(client, ann, role="drive", publish=["cmd_vel"], subscribe=["odom"])
    problem_of(await client.post(goals, headers=bob, json={"pose": [1, 1]}), 403, "not-permitted")
    problem_of(await client.delete(goals, headers=bob), 403, "not-permitted")
    problem_of(await client.get("/v1/robots/ann:tb1/state", headers=bob), 403, "not-permitted")
    await share(client, ann, role="drive", publish=["move_base*"])
    assert (await client.post(goals, headers=bob, json={"pose": [0.2, 0.1]})).status_code == 201
    [goal] = (await client.get("/v1/robots/tb1/goals", headers=ann)).json()["items"]
    assert goal["pose"] == [0.2, 0.1, 0.0]
    cloud.robots.close()


async def test_a_robot_keeps_its_owner_and_shares_when_another_user_changes_it(
    client: httpx.AsyncClient, ann: Header, bob: Header, publish: Publish, services: Services
) -> None:
    await share(client, ann, role="administer")
    url = "/v1/robots/ann:tb1"
    await publish(bob, "secret")
    problem_of(await client.put(url, headers=bob, json={"map": "secret"}), 422, "invalid-parameter")
    problem_of(await client.put(url, headers=bob, json={"map": "house"}), 404, "not-found")  # bob may not read it
    await client.patch("/v1/maps/house", headers=ann, json={"readers": ["bob"]})
    changed = await client.put(url, headers=bob, json={"map": "house", "cores": 0.5})
    assert (changed.status_code, changed.json()["user"]) == (200, "ann")
    assert (await client.patch(url, headers=bob, json={"cores": 0.25})).json()["cores"] == 0.25
    assert [one.to for one in services.store.robot("ann", "tb1").shares] == ["bob"]
    assert (await client.put("/v1/robots/tb1", headers=ann, json={"map": "house"})).status_code == 200
    assert [one.to for one in services.store.robot("ann", "tb1").shares] == ["bob"]
    problem_of(await client.put("/v1/robots/ann:new", headers=bob, json={"map": "house"}), 404, "not-found")


async def test_a_map_is_read_by_those_who_may_hear_it_from_a_robot(
    client: httpx.AsyncClient, ann: Header, bob: Header
) -> None:
    reads = [f"/v1/maps/house{part}" for part in ("", "/yaml", "/image", "/cells", "/versions")]
    assert {(await client.get(url, headers=bob)).status_code for url in reads} == {404}
    await share(client, ann, role="look", subscribe=["odom"])
    assert {(await client.get(url, headers=bob)).status_code for url in reads} == {404}
    await share(client, ann, role="look", subscribe=["map"])
    assert {(await client.get(url, headers=bob)).status_code for url in reads} == {200}
    own = await client.put("/v1/robots/mine", headers=bob, json={"map": "house"})
    problem_of(own, 404, "not-found")  # a robot of his own would show the map after the share has ended
    problem_of(await client.patch("/v1/maps/house", headers=bob, json={"readers": ["*"]}), 403, "not-permitted")
    await client.delete(f"{SHARES}/bob", headers=ann)
    assert {(await client.get(url, headers=bob)).status_code for url in reads} == {404}


async def test_stored_paths_on_a_map_are_seen_by_those_who_may_hear_them_from_a_robot(
    client: httpx.AsyncClient, ann: Header, bob: Header, services: Services
) -> None:
    version = services.map_store.map_head("house").version
    for number, (user, robot) in enumerate([("ann", "tb1"), ("ann", "tb2"), ("ann", None), ("bob", None)]):
        created = epoch() + 60.0 + number  # later than users and robots
        fields = {"user": user, "robot": robot, "created": created, "version": version, "poses": POSES}
        services.store.add_plan(records.plan(f"p{number}", **fields))

    async def seen(who: Header) -> tuple[list[str], list[str], list[int]]:
        listed = await client.get("/v1/maps/house/plans", headers=who, params={"limit": 1})
        ids = []
        while True:
            page = listed.json()
            ids += [plan["plan_id"] for plan in page["items"]]
            if page["next"] is None:
                break
            query = {"limit": 1, "cursor": page["next"]}
            listed = await client.get("/v1/maps/house/plans", headers=who, params=query)
        found = await client.get("/v1/plans", headers=who, params=ENDS)
        shown = [(await client.get(f"/v1/plans/p{number}", headers=who)).status_code for number in range(4)]
        return ids, sorted(plan["plan_id"] for plan in found.json()["items"]), shown

    await share(client, ann, role="look", subscribe=["map"])
    assert await seen(bob) == (["p3"], ["p3"], [404, 404, 404, 200])
    await share(client, ann, role="look", subscribe=["map", "plan"])
    assert await seen(bob) == (["p3", "p0"], ["p0", "p3"], [200, 404, 404, 200])
    assert await seen(ann) == (["p3", "p2", "p1", "p0"], ["p0", "p1", "p2", "p3"], [200] * 4)


async def test_users_end_what_is_shared_with_them_and_not_with_others(
    client: httpx.AsyncClient, ann: Header, bob: Header
) -> None:
    await share(client, ann, role="drive")
    await share(client, ann, "carl", role="look")
    url = "/v1/robots/ann:tb1/shares"
    problem_of(await client.get(url, headers=bob), 403, "not-permitted")
    problem_of(await client.put(f"{url}/dora", headers=bob, json={"role": "look"}), 403, "not-permitted")
    problem_of(await client.delete(f"{url}/carl", headers=bob), 403, "not-permitted")
    assert (await client.delete(f"{url}/bob", headers=bob)).status_code == 204
    problem_of(await client.get("/v1/robots/ann:tb1", headers=bob), 404, "not-found")


async def test_a_later_user_of_the_same_id_gets_nothing_of_a_removed_user(
    client: httpx.AsyncClient, ann: Header, bob: Header, log_in: LogIn
) -> None:
    await share(client, ann, role="drive")
    assert (await client.delete("/v1/users/bob", headers=await log_in("admin"))).status_code == 204
    problem_of(await client.get("/v1/robots/ann:tb1", headers=await log_in("bob")), 404, "not-found")
    assert (await client.get(SHARES, headers=ann)).json()["items"] == []


async def test_shares_are_recorded_in_the_audit_log(client: httpx.AsyncClient, ann: Header, services: Services) -> None:
    await share(client, ann, role="drive", publish=["cmd_vel"])
    [event] = services.audit.read(AuditQuery(action="share_robot"))
    assert event.object == "robots/tb1/shares/bob"
    assert event.details == {"role": "drive", "publish": ["cmd_vel"]}


async def test_containers_of_shared_robots_are_shown_and_changed_by_the_role(
    client: httpx.AsyncClient, ann: Header, bob: Header, cloud: FakeCloud
) -> None:
    cloud.running = [container("c1"), container("c2", robot="tb2"), container("c3", robot=None, kind="planning")]
    assert (await client.get("/v1/containers", headers=bob)).json()["items"] == []
    await share(client, ann, role="drive")
    assert [one["id"] for one in (await client.get("/v1/containers", headers=bob)).json()["items"]] == ["c1"]
    assert (await client.get("/v1/containers/c1", headers=bob)).status_code == 200
    for method, body in (("DELETE", None), ("PATCH", {"cores": 0.5})):
        refused = await client.request(method, "/v1/containers/c1", headers=bob, json=body)
        assert "needs the role 'administer'" in problem_of(refused, 403, "not-permitted")["detail"]
        problem_of(await client.request(method, "/v1/containers/c2", headers=bob, json=body), 404, "not-found")
    await share(client, ann, role="administer")
    assert (await client.delete("/v1/containers/c1", headers=bob)).status_code == 202
