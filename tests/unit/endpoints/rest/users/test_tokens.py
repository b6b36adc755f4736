"""Tokens over REST."""

from typing import Any

import httpx
import pytest

from endpoints.accounts.shared_logins import USER_AT_ADDRESS
from endpoints.accounts.tokens import token_id
from endpoints.resources.services import Services
from ppaas.clock import ManualClock
from storage.sharing_records import Share
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import robot
from tests.unit.endpoints.conftest import PASSWORD, LogIn, Publish


async def test_a_login_returns_a_token_that_is_not_cached(client: httpx.AsyncClient, services: Services) -> None:
    await services.accounts.register("ann", PASSWORD)
    answer = await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD})
    assert answer.status_code == 201
    assert answer.headers["cache-control"] == "no-store"
    assert answer.json()["expires"] == 1_000_000.0 + 30 * 24 * 3600
    me = await client.get("/v1/users/me", headers={"Authorization": f"bearer {answer.json()['token']}"})
    assert (me.json()["id"], me.json()["role"]) == ("ann", "user")


async def test_a_token_in_the_address_is_refused_with_the_header_to_use(
    client: httpx.AsyncClient, log_in: LogIn
) -> None:
    header = await log_in("ann")
    token = {"token": header["Authorization"].split()[1]}
    refused = problem_of(await client.get("/v1/users/me", params=token), 401, "not-authenticated")
    assert "Authorization: Bearer TOKEN" in refused["detail"] and "address" in refused["detail"]
    assert (await client.get("/v1/users/me", params=token, headers=header)).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [{}, {"Authorization": "Bearer"}, {"Authorization": "Bearer x"}, {"Authorization": "Basic YTpi"}],
)
@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/v1/users/me"),
        ("GET", "/v1/users"),
        ("DELETE", "/v1/users/ann"),
        ("GET", "/v1/maps"),
        ("POST", "/v1/maps"),
        ("GET", "/v1/maps/house"),
        ("GET", "/v1/maps/house/yaml"),
        ("GET", "/v1/maps/house/image"),
        ("DELETE", "/v1/maps/house"),
        ("GET", "/v1/robots"),
        ("DELETE", "/v1/robots/tb1"),
        ("GET", "/v1/plans/x"),
        ("GET", "/v1/machines"),
        ("GET", "/v1/containers"),
    ],
)
async def test_requests_without_a_valid_token_are_refused(
    client: httpx.AsyncClient, method: str, path: str, headers: dict[str, str]
) -> None:
    answer = await client.request(method, path, headers=headers)
    problem_of(answer, 401, "not-authenticated")
    assert answer.headers["www-authenticate"].startswith("Bearer")


async def test_login_errors_do_not_repeat_the_password(client: httpx.AsyncClient, services: Services) -> None:
    await services.accounts.register("ann", PASSWORD)
    answer = await client.post("/v1/tokens", json={"user": "ann", "password": "secret-but-wrong"})
    problem_of(answer, 401, "not-authenticated")
    refused = await client.post("/v1/tokens", json={"user": "ann", "password": ["secret-but-wrong"]})
    problem_of(refused, 422, "invalid-request")
    assert "secret" not in answer.text + refused.text


async def test_tokens_are_listed_by_id_and_revoked_one_by_one(client: httpx.AsyncClient, log_in: LogIn) -> None:
    here, elsewhere, bob = await log_in("ann"), await log_in("ann"), await log_in("bob")
    listed = (await client.get("/v1/tokens", headers=here)).json()["items"]
    assert len(listed) == 2
    assert all(one["created"] == 1_000_000.0 and one["expires"] > one["created"] for one in listed)
    assert here["Authorization"].split()[1] not in str(listed)
    [other] = [one["id"] for one in listed if not one["current"]]
    problem_of(await client.delete(f"/v1/tokens/{other}", headers=bob), 404, "not-found")
    assert (await client.delete(f"/v1/tokens/{other}", headers=here)).status_code == 204
    problem_of(await client.get("/v1/users/me", headers=elsewhere), 401, "not-authenticated")
    assert (await client.delete("/v1/tokens/current", headers=here)).status_code == 204
    problem_of(await client.get("/v1/users/me", headers=here), 401, "not-authenticated")
    assert (await client.get("/v1/users/me", headers=bob)).status_code == 200


async def test_a_new_token_has_the_id_shown_in_the_list(client: httpx.AsyncClient, log_in: LogIn) -> None:
    await log_in("ann")
    made = (await client.post("/v1/tokens", json={"user": "ann", "password": PASSWORD})).json()
    listed = await client.get("/v1/tokens", headers={"Authorization": f"Bearer {made['token']}"})
    assert [one["id"] for one in listed.json()["items"] if one["current"]] == [made["id"]]


async def test_too_many_wrong_passwords_are_refused_with_the_time_to_wait(
    client: httpx.AsyncClient, services: Services, caplog: pytest.LogCaptureFixture
) -> None:
    await services.accounts.register("ann", PASSWORD)
    wrong = {"user": "ann", "password": "secret-but-wrong"}
    answers = [await client.post("/v1/tokens", json=wrong) for _ in range(USER_AT_ADDRESS.failures + 1)]
    assert [answer.status_code for answer in answers] == [401] * USER_AT_ADDRESS.failures + [429]
    problem_of(answers[-1], 429, "too-many-attempts")
    assert answers[-1].headers["retry-after"] == "1"
    failures = [record.getMessage() for record in caplog.records if record.name == "endpoints.accounts.accounts"]
    assert len(failures) == USER_AT_ADDRESS.failures
    assert failures[0] == "login of 'ann' from 127.0.0.1 failed (1 in a row)"
    assert "secret-but-wrong" not in caplog.text


async def test_guesses_of_the_old_password_are_throttled_too(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    headers = await log_in("ann")
    change = {"password": "another pass word", "old_password": "a wrong guess"}
    answers = [
        (await client.patch("/v1/users/me", json=change, headers=headers)).status_code
        for _ in range(USER_AT_ADDRESS.failures + 1)
    ]
    assert answers == [403] * USER_AT_ADDRESS.failures + [429]


# Tickets over REST.


async def test_a_ticket_stands_for_the_token_of_the_request(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    header = await log_in("ann")
    answer = await client.post("/v1/tickets", headers=header)
    assert answer.status_code == 201
    assert answer.headers["cache-control"] == "no-store"
    assert answer.json()["expires_in"] == 30.0
    token = header["Authorization"].split()[1]
    assert await services.accounts.redeem_ticket(answer.json()["ticket"]) == token_id(token)


async def test_a_ticket_needs_a_token(client: httpx.AsyncClient) -> None:
    problem_of(await client.post("/v1/tickets"), 401, "not-authenticated")


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


# Tokens for some robots only, over REST.


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
