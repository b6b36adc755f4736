"""Tokens over REST."""

import httpx
import pytest

from endpoints.accounts.login_throttle import USER_AT_ADDRESS
from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import PASSWORD, LogIn


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
