"""Tokens for some robots only, over REST."""

from typing import Any

import httpx
import pytest

from endpoints.services.services import Services
from ppaas.clock import ManualClock
from storage.sharing_records import Share
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import robot
from tests.unit.endpoints.conftest import LogIn, Publish

Header = dict[str, str]


@pytest.fixture
async def ann(client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services) -> Header:
    """Return the header of a user with two robots, and one that is shared with her."""
    header = await log_in("ann")
    await publish(header)
    for name in ("tb1", "kobuki"):
        services.store.put_robot(robot(name, user="ann", map="house"))
    await log_in("carl")
    services.store.put_robot(robot("tb1", user="carl", shares=(Share("ann", "look"),)))
    return header


async def created(client: httpx.AsyncClient, header: Header, **wanted: Any) -> Header:
    answer = await client.post("/v1/scoped-tokens", headers=header, json={"robots": ["tb*"], "role": "look"} | wanted)
    assert answer.status_code == 201, answer.text
    assert answer.headers["cache-control"] == "no-store"
    return {"Authorization": f"Bearer {answer.json()['token']}"}


async def test_a_token_is_good_for_its_robots_alone(client: httpx.AsyncClient, ann: Header) -> None:
    wall = await created(client, ann, name="display in hall 2")
    listed = (await client.get("/v1/robots", headers=wall)).json()["items"]
    assert [one["id"] for one in listed] == ["tb1"]
    assert (await client.get("/v1/robots?shared=true", headers=wall)).json()["items"] == []
    assert (await client.get("/v1/robots/tb1", headers=wall)).json()["role"] == "look"
    for url in ("/v1/robots/kobuki", "/v1/robots/carl:tb1"):
        problem_of(await client.get(url, headers=wall), 403, "not-permitted")
    both = await created(client, ann, robots=["carl:*", "k?buki"], role="administer")
    assert (await client.get("/v1/robots/carl:tb1", headers=both)).json()["role"] == "look"
    assert (await client.get("/v1/robots/kobuki", headers=both)).json()["role"] == "administer"
    [shared] = (await client.get("/v1/robots?shared=true", headers=both)).json()["items"]
    assert (shared["user"], shared["id"]) == ("carl", "tb1")


async def test_a_token_of_an_administrator_has_no_rights_of_administrators(
    client: httpx.AsyncClient, ann: Header, log_in: LogIn
) -> None:
    token = await created(client, await log_in("admin"), robots=["*:*"], role="administer")
    problem_of(await client.get("/v1/robots/ann:tb1", headers=token), 404, "not-found")
    for url in ("/v1/users", "/v1/machines", "/v1/audit", "/v1/containers"):
        problem_of(await client.get(url, headers=token), 403, "not-permitted")


async def test_a_token_makes_no_other_tokens_and_revokes_only_itself(client: httpx.AsyncClient, ann: Header) -> None:
    wall = await created(client, ann, role="administer")
    wanted = {"robots": ["*"], "role": "administer"}
    refused = await client.post("/v1/scoped-tokens", headers=wall, json=wanted)
    text = "this token is for the robots tb* only: log in and use a token without a scope"
    assert problem_of(refused, 403, "not-permitted")["detail"] == text
    problem_of(await client.get("/v1/tokens", headers=wall), 403, "not-permitted")
    [login] = [one for one in (await client.get("/v1/tokens", headers=ann)).json()["items"] if one["current"]]
    problem_of(await client.delete(f"/v1/tokens/{login['id']}", headers=wall), 403, "not-permitted")
    shares = "/v1/robots/tb1/shares/bob"
    problem_of(await client.put(shares, headers=wall, json={"role": "look"}), 403, "not-permitted")
    assert (await client.delete("/v1/tokens/current", headers=wall)).status_code == 204
    problem_of(await client.get("/v1/robots", headers=wall), 401, "not-authenticated")


async def test_tokens_are_listed_with_what_they_are_for_and_revoked(client: httpx.AsyncClient, ann: Header) -> None:
    wall = await created(client, ann, name="display", subscribe=["/map", "amcl_pose"], expires_in=3600)
    listed = (await client.get("/v1/tokens", headers=ann)).json()["items"]
    [one] = [token for token in listed if token["scope"] is not None]
    assert one["name"] == "display"
    assert one["scope"] == {"robots": ["tb*"], "role": "look", "publish": [], "subscribe": ["map", "amcl_pose"]}
    assert one["expires"] == 1_000_000.0 + 3600.0
    assert (await client.delete(f"/v1/tokens/{one['id']}", headers=ann)).status_code == 204
    problem_of(await client.get("/v1/robots", headers=wall), 401, "not-authenticated")


async def test_a_token_expires(client: httpx.AsyncClient, ann: Header, clock: ManualClock) -> None:
    wall = await created(client, ann, expires_in=3600)
    assert (await client.get("/v1/robots", headers=wall)).status_code == 200
    clock.advance(3600.0)
    problem_of(await client.get("/v1/robots", headers=wall), 401, "not-authenticated")


async def test_a_token_reads_the_maps_that_its_robots_show(client: httpx.AsyncClient, ann: Header) -> None:
    reads = [f"/v1/maps/house{part}" for part in ("", "/yaml", "/image", "/cells")]
    shows = await created(client, ann, subscribe=["map"])
    assert {(await client.get(url, headers=shows)).status_code for url in reads} == {200}
    for other in (await created(client, ann, subscribe=["odom"]), await created(client, ann, robots=["carl:*"])):
        assert {(await client.get(url, headers=other)).status_code for url in reads} == {404}
    plan = b'{"start": [0.1, 0.1], "goal": [0.2, 0.1]}'
    for kind in ("application/json", "application/json; charset=utf-8"):
        header = shows | {"Content-Type": kind}
        answer = await client.post("/v1/maps/house/plans", headers=header, content=plan)
        problem_of(answer, 403, "not-permitted")


async def test_a_ticket_of_a_token_has_its_scope(client: httpx.AsyncClient, ann: Header, services: Services) -> None:
    wall = await created(client, ann)
    ticket = (await client.post("/v1/tickets", headers=wall)).json()["ticket"]
    user = await services.accounts.user_of(await services.accounts.redeem_ticket(ticket))
    assert (user.id, user.scope.role) == ("ann", "look")  # type: ignore[attr-defined]


async def test_a_new_password_revokes_tokens_with_a_scope_too(
    client: httpx.AsyncClient, ann: Header, services: Services
) -> None:
    wall = await created(client, ann)
    await services.accounts.change("ann", password="another password")
    problem_of(await client.get("/v1/robots", headers=wall), 401, "not-authenticated")


@pytest.mark.parametrize(
    "wanted",
    [
        {"robots": []}, {"robots": ["a/b"]}, {"robots": ["a:b:c"]}, {"role": "owner"}, {"expires_in": 59},
        {"expires_in": 367 * 86400}, {"role": "look", "publish": ["cmd_vel"]}, {"name": "x" * 101}, {"subscribe": [""]},
    ],
    ids=str,
)  # fmt: skip
async def test_invalid_scopes_are_refused(client: httpx.AsyncClient, ann: Header, wanted: dict[str, Any]) -> None:
    body = {"robots": ["tb*"], "role": "look"} | wanted
    answer = await client.post("/v1/scoped-tokens", headers=ann, json=body)
    problem_of(answer, 422, "invalid-request")
