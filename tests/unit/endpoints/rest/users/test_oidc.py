"""Logins with an identity provider over REST, against a provider over real sockets: honest, lying, slow, away."""

import asyncio
import dataclasses
import json
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import parse_qs, urlsplit

import httpx
import msgspec
import pytest
from starlette.responses import JSONResponse, Response, StreamingResponse

from endpoints.audit.event import AuditQuery
from endpoints.oidc.provider import PAUSE
from endpoints.oidc.settings import OidcSettings
from endpoints.resources.services import Services
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from storage.sharing_records import ProvidedIdentity
from tests.support.endpoints.problems import problem_of
from tests.support.identity.identity_server import AUDIENCE, CLIENT, SECRET, IdentityServer, new_key
from tests.unit.endpoints.conftest import PASSWORD, LogIn
from tests.unit.endpoints.rest.users.conftest import CLOUD, Open


async def by_browser(web: httpx.AsyncClient, **change: str) -> httpx.Response:
    """Log in as a browser does; ``change`` is of what it sends at the end."""
    begun = (await web.post("/v1/oidc/logins")).json()
    async with httpx.AsyncClient() as browser:
        sent = await browser.get(begun["url"])
    back = {name: values[0] for name, values in parse_qs(urlsplit(sent.headers["location"]).query).items()}
    assert back["state"] == begun["state"]
    body = {"code": back["code"], "iss": back["iss"], "nonce": begun["nonce"], "verifier": begun["verifier"]}
    return await web.post("/v1/oidc/codes", json=body | change)


async def by_program(web: httpx.AsyncClient, token: str) -> httpx.Response:
    return await web.post("/v1/oidc/access-tokens", json={"access_token": token})


async def me(web: httpx.AsyncClient, login: httpx.Response) -> dict[str, Any]:
    header = {"Authorization": f"Bearer {login.json()['token']}"}
    found: dict[str, Any] = (await web.get("/v1/users/me", headers=header)).json()
    return found


async def test_a_browser_logs_in_and_gets_an_ordinary_token(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services
) -> None:
    login = await by_browser(web)
    assert login.status_code == 201, login.text
    assert login.headers["cache-control"] == "no-store"
    assert login.json()["expires"] == 1_000_000.0 + 12 * 3600
    assert ((await me(web, login))["id"], (await me(web, login))["role"]) == ("ann", "user")
    assert services.store.user("ann").identity == ProvidedIdentity(idp.issuer, "id-of-ann")
    logout = urlsplit(login.json()["logout_url"])
    assert f"{logout.scheme}://{logout.netloc}{logout.path}" == f"{idp.issuer}/logout"
    assert parse_qs(logout.query)["post_logout_redirect_uri"] == [f"{CLOUD}/dashboard/"]


async def test_the_address_at_the_provider_has_pkce_and_the_redirect_of_the_settings(web: httpx.AsyncClient) -> None:
    url = (await web.post("/v1/oidc/logins", headers={"Host": "evil.example", "X-Forwarded-Host": "evil"})).json()[
        "url"
    ]
    query = parse_qs(urlsplit(url).query)
    assert query["redirect_uri"] == [f"{CLOUD}/dashboard/"]
    assert (query["code_challenge_method"], query["response_type"]) == (["S256"], ["code"])
    assert len(query["code_challenge"][0]) == 43 and query["scope"] == ["openid profile"]
    other = (await web.post("/v1/oidc/logins?again=true")).json()
    assert "prompt" not in query and parse_qs(urlsplit(other["url"]).query)["prompt"] == ["login"]
    assert {"state", "nonce", "verifier", "url"} == other.keys()
    assert parse_qs(urlsplit(other["url"]).query)["state"] != query["state"]


async def test_the_provider_is_named_without_a_token(web: httpx.AsyncClient, client: httpx.AsyncClient) -> None:
    assert (await web.get("/v1/oidc")).json() == {"name": "127.0.0.1"}
    assert (await client.get("/v1/oidc")).json() == {"name": None}
    for path in ("logins", "devices"):
        problem_of(await client.post(f"/v1/oidc/{path}"), 404, "not-found")
    problem_of(await by_program(client, "x"), 404, "not-found")


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"code": "invented"}, "invalid_grant"),
        ({"verifier": "v" * 43}, "invalid_grant"),
        ({"nonce": "n" * 43}, "nonce"),
        ({"iss": "https://evil.example"}, "another identity provider"),
    ],
)
async def test_what_is_not_of_this_login_is_refused(web: httpx.AsyncClient, change: dict[str, str], why: str) -> None:
    assert why in problem_of(await by_browser(web, **change), 401, "not-authenticated")["detail"]


async def test_a_code_is_good_once(web: httpx.AsyncClient) -> None:
    begun = (await web.post("/v1/oidc/logins")).json()
    async with httpx.AsyncClient() as browser:
        location = (await browser.get(begun["url"])).headers["location"]
    code = parse_qs(urlsplit(location).query)["code"][0]
    body = {"code": code, "nonce": begun["nonce"], "verifier": begun["verifier"]}
    assert (await web.post("/v1/oidc/codes", json=body)).status_code == 201
    problem_of(await web.post("/v1/oidc/codes", json=body), 401, "not-authenticated")


@pytest.mark.parametrize(
    "lie",
    [
        {"iss": "https://evil.example"},
        {"aud": "another client"},
        {"azp": "another client"},
        {"exp": 1},
        {"nbf": 2_000_000_000_000},
        {"nonce": "another login"},
        {"sub": ""},
    ],
    ids=lambda lie: next(iter(lie)),
)
async def test_a_provider_that_lies_logs_nobody_in(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services, lie: dict[str, Any]
) -> None:
    idp.alter = lambda claims: claims.update(lie)
    problem_of(await by_browser(web), 401, "not-authenticated")
    assert services.store.users() == []


# Who somebody is.


async def test_an_identity_does_not_get_the_local_user_of_its_name(
    web: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    header = await log_in("ann")
    refused = problem_of(await by_browser(web), 409, "conflict")
    assert "ppaas user link ann id-of-ann" in refused["detail"]
    assert (await web.get("/v1/users/me", headers=header)).json()["id"] == "ann"
    assert services.store.user("ann").identity is None


@pytest.mark.parametrize("name", ["admin", "me"])
async def test_reserved_names_are_nobodys(web: httpx.AsyncClient, idp: IdentityServer, name: str) -> None:
    idp.person.claims["preferred_username"] = name
    problem_of(await by_browser(web), 409, "conflict")


async def test_a_name_that_changes_or_goes_to_somebody_else_changes_nothing(
    web: httpx.AsyncClient, idp: IdentityServer
) -> None:
    await by_browser(web)
    idp.person.claims["preferred_username"] = "ann-married"
    assert (await by_browser(web)).json()["user"] == "ann"
    idp.person.subject, idp.person.claims["preferred_username"] = "id-of-another-ann", "ann"
    problem_of(await by_browser(web), 409, "conflict")


async def test_an_administrator_links_a_user_to_an_identity(
    web: httpx.AsyncClient, idp: IdentityServer, log_in: LogIn
) -> None:
    admin, ann = await log_in("admin"), await log_in("ann")
    identity = {"issuer": idp.issuer, "subject": "id-of-ann"}
    problem_of(await web.patch("/v1/users/ann", json={"identity": identity}, headers=ann), 403, "not-permitted")
    problem_of(await web.patch("/v1/users/admin", json={"identity": identity}, headers=admin), 409, "conflict")
    linked = await web.patch("/v1/users/ann", json={"identity": identity}, headers=admin)
    assert linked.json()["identity"] == identity
    login = await by_browser(web)
    assert login.json()["user"] == "ann"
    await log_in("bob")
    problem_of(await web.patch("/v1/users/bob", json={"identity": identity}, headers=admin), 409, "conflict")
    assert (await web.patch("/v1/users/ann", json={"identity": None}, headers=admin)).json()["identity"] is None
    header = {"Authorization": f"Bearer {login.json()['token']}"}
    problem_of(await web.get("/v1/users/me", headers=header), 401, "not-authenticated")
    problem_of(await by_browser(web), 409, "conflict")


async def test_a_user_without_a_password_has_none_that_logs_in(web: httpx.AsyncClient, services: Services) -> None:
    await by_browser(web)
    for password in ("provided:", services.store.user("ann").password_hash, PASSWORD):
        body = {"user": "ann", "password": password}
        problem_of(await web.post("/v1/tokens", json=body), 401, "not-authenticated")


async def test_the_role_follows_the_groups_at_each_login(web: httpx.AsyncClient, idp: IdentityServer) -> None:
    first = await by_browser(web)
    idp.person.claims["groups"] = ["staff", "operators"]
    await by_browser(web)
    assert (await me(web, first))["role"] == "admin"
    idp.person.claims["groups"] = ["staff"]
    await by_browser(web)
    assert (await me(web, first))["role"] == "user"
    idp.person.claims["groups"] = []
    problem_of(await by_browser(web), 403, "not-permitted")


async def test_a_login_ends_although_nobody_tells(
    web: httpx.AsyncClient, clock: ManualClock, services: Services
) -> None:
    login = await by_browser(web)
    clock.advance(12 * 3600 + 1)
    header = {"Authorization": f"Bearer {login.json()['token']}"}
    problem_of(await web.get("/v1/users/me", headers=header), 401, "not-authenticated")


async def test_the_address_of_a_name_is_taken_only_if_it_is_verified(
    opened: Open, settings: OidcSettings, idp: IdentityServer
) -> None:
    web = await opened(dataclasses.replace(settings, username_claim="email"))
    idp.person.claims |= {"email": "ann@lab.example", "email_verified": False}
    assert "verified" in problem_of(await by_browser(web), 401, "not-authenticated")["detail"]
    idp.person.claims["email_verified"] = True
    assert (await by_browser(web)).json()["user"] == "ann-lab.example"


# Programs.


async def test_a_program_gets_a_token_that_lives_as_long_as_its_own(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services
) -> None:
    idp.person.claims = {"client_id": "fleet", "groups": ["staff"]}
    login = await by_program(web, idp.token(AUDIENCE))
    assert login.status_code == 201, login.text
    assert login.json()["user"] == "fleet" and login.json()["logout_url"] is None
    assert 0 < login.json()["expires"] - 1_000_000.0 <= 300
    endless = await by_program(web, idp.token(AUDIENCE, exp=10**400))
    assert endless.json()["expires"] - 1_000_000.0 == pytest.approx(12 * 3600)


@pytest.mark.parametrize("audience", [CLIENT, "account", "another service"])
async def test_a_token_for_another_audience_is_no_login(
    web: httpx.AsyncClient, idp: IdentityServer, audience: str
) -> None:
    problem_of(await by_program(web, idp.token(audience)), 401, "not-authenticated")


async def test_without_an_audience_no_access_token_is_taken(
    opened: Open, settings: OidcSettings, idp: IdentityServer
) -> None:
    web = await opened(dataclasses.replace(settings, audience=""))
    for audience in ("", AUDIENCE, CLIENT):
        problem_of(await by_program(web, idp.token(audience)), 401, "not-authenticated")


# Keys.


async def test_a_new_key_is_looked_for_once_in_a_while(
    web: httpx.AsyncClient, idp: IdentityServer, monotonic: ManualClock
) -> None:
    await by_browser(web)
    idp.keys.append(new_key("second"))
    assert (await by_program(web, idp.token(AUDIENCE))).status_code == 201
    assert idp.asked.count("keys") == 2
    invented = new_key("invented")
    for _ in range(5):
        forged = idp.signed({"iss": idp.issuer}, invented)
        problem_of(await by_program(web, forged), 401, "not-authenticated")
    assert idp.asked.count("keys") == 2, "who invents keys does not make the cloud ask each time"
    idp.keys.append(new_key("third"))
    problem_of(await by_program(web, idp.token(AUDIENCE)), 401, "not-authenticated")
    monotonic.advance(PAUSE)
    assert (await by_program(web, idp.token(AUDIENCE))).status_code == 201


async def test_a_withdrawn_key_is_taken_for_an_hour_at_most(
    web: httpx.AsyncClient, idp: IdentityServer, monotonic: ManualClock
) -> None:
    token = idp.token(AUDIENCE)
    assert (await by_program(web, token)).status_code == 201
    idp.keys = [new_key("second")]
    monotonic.advance(3601)
    problem_of(await by_program(web, token), 401, "not-authenticated")


# A provider that is away, slow, or none.


async def slow() -> AsyncIterator[bytes]:
    yield b'{"issuer":'
    await asyncio.sleep(60)


async def endless() -> AsyncIterator[bytes]:
    while True:
        yield b" " * 65_536
        await asyncio.sleep(0)


@pytest.mark.parametrize(
    "answer",
    [
        lambda: StreamingResponse(slow()),
        lambda: StreamingResponse(endless()),
        lambda: Response("<html>", media_type="text/html"),
        lambda: Response(b"\x1f\x8b", headers={"Content-Encoding": "gzip"}),
        lambda: JSONResponse([]),
        lambda: JSONResponse({"issuer": 7}),
        lambda: JSONResponse({}, status_code=500),
        lambda: Response(status_code=302, headers={"Location": "https://evil.example"}),
    ],
    ids=["slow", "endless", "html", "compressed", "list", "number", "broken", "redirect"],
)
async def test_a_provider_that_does_not_answer_stops_no_other_login(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services, answer: Callable[[], Response]
) -> None:
    await services.accounts.register("bob", PASSWORD)
    idp.answers["metadata"] = answer()
    problem = problem_of(await web.post("/v1/oidc/logins"), 503, "unavailable")
    assert "passwords and tokens work as before" in problem["detail"]
    login = await web.post("/v1/tokens", json={"user": "bob", "password": PASSWORD})
    assert login.status_code == 201


async def test_a_provider_that_is_away_is_asked_again_later(
    opened: Open, settings: OidcSettings, idp: IdentityServer, monotonic: ManualClock
) -> None:
    web = await opened(settings)
    idp.answers["metadata"] = JSONResponse({}, status_code=502)
    for _ in range(5):
        problem_of(await web.post("/v1/oidc/logins"), 503, "unavailable")
    assert idp.asked == ["metadata"], "logins fail at once, and do not wait one after the other"
    del idp.answers["metadata"]
    monotonic.advance(3.0)
    assert (await by_browser(web)).status_code == 201


@pytest.mark.parametrize(
    "metadata",
    [
        {"issuer": "https://evil.example"},
        {"token_endpoint": "http://10.0.0.1/token"},
        {"authorization_endpoint": "javascript:alert(1)"},
        {"jwks_uri": "file:///etc/passwd"},
        {"end_session_endpoint": "javascript:alert(1)"},
        {"device_authorization_endpoint": "ftp://x"},
    ],
    ids=lambda metadata: next(iter(metadata)),
)
async def test_metadata_of_another_or_with_unsafe_addresses_is_refused(
    web: httpx.AsyncClient, idp: IdentityServer, metadata: dict[str, str]
) -> None:
    idp.metadata = metadata
    problem_of(await web.post("/v1/oidc/logins"), 503, "unavailable")


@pytest.mark.parametrize("keys", [{"keys": []}, {"keys": [{"kty": "oct", "k": "c2VjcmV0"}]}, {"keys": 7}, {}])
async def test_a_provider_without_key_pairs_logs_nobody_in(
    web: httpx.AsyncClient, idp: IdentityServer, keys: dict[str, Any]
) -> None:
    idp.answers["keys"] = JSONResponse(keys)
    problem_of(await web.post("/v1/oidc/logins"), 503, "unavailable")


def change(file: Path, text: str | None) -> None:
    file.unlink() if text is None else file.write_text(text)


async def test_a_wrong_secret_of_the_client_is_the_operators_fault(web: httpx.AsyncClient, secret: Path) -> None:
    change(secret, "another secret")
    assert "settings are wrong" in problem_of(await by_browser(web), 503, "unavailable")["detail"]
    change(secret, None)
    problem = problem_of(await by_browser(web), 503, "unavailable")
    assert str(secret) not in json.dumps(problem)
    change(secret, SECRET)
    assert (await by_browser(web)).status_code == 201, "the secret may be replaced while the cloud runs"


async def test_a_store_that_fails_makes_logins_unavailable(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_user: str) -> NoReturn:
        raise Unavailable("the disk is full: free space")

    monkeypatch.setattr(services.store, "user", fail)
    assert "free space" in problem_of(await by_browser(web), 503, "unavailable")["detail"]


# Audit log.


async def test_logins_and_refusals_are_in_the_audit_log_without_secrets(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services
) -> None:
    await by_browser(web)
    await by_browser(web, nonce="n" * 43)
    recorded = services.audit.read(AuditQuery())
    events = [event for event in reversed(recorded) if event.action == "log_in_by_code"]
    assert [(event.outcome, event.user, event.object) for event in events] == [
        ("ok", "ann", "users/ann"),
        ("refused", None, "users/(unknown)"),
    ]
    assert events[0].details["subject"] == "id-of-ann" and events[0].details["created"] is True
    text = str([msgspec.to_builtins(event) for event in recorded])
    assert "verifier" not in text and SECRET not in text and "eyJ" not in text


# Devices.


async def test_a_device_waits_for_its_person_without_filling_the_audit_log(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services
) -> None:
    begun = await web.post("/v1/oidc/devices")
    assert begun.status_code == 201 and begun.headers["cache-control"] == "no-store"
    body = {name: begun.json()[name] for name in ("device_code", "verifier")}
    for _ in range(3):
        waiting = await web.post("/v1/oidc/device-tokens", json=body)
        assert (waiting.status_code, waiting.json()) == (202, {"slower": False})
    idp.answers["token"] = JSONResponse({"error": "slow_down"}, status_code=400)
    assert (await web.post("/v1/oidc/device-tokens", json=body)).json() == {"slower": True}
    del idp.answers["token"]
    idp.devices = dict.fromkeys(idp.devices, True)
    other = await web.post("/v1/oidc/device-tokens", json=body | {"verifier": "v" * 43})
    problem_of(other, 401, "not-authenticated")
    login = await web.post("/v1/oidc/device-tokens", json=body)
    assert login.status_code == 201 and login.json()["user"] == "ann"
    actions = [event.outcome for event in services.audit.read(AuditQuery()) if event.action == "log_in_by_device"]
    assert actions == ["ok", "refused"]


@pytest.mark.parametrize("error", ["access_denied", "expired_token"])
async def test_a_device_that_is_refused_is_told_to_begin_again(
    web: httpx.AsyncClient, idp: IdentityServer, error: str
) -> None:
    begun = (await web.post("/v1/oidc/devices")).json()
    idp.answers["token"] = JSONResponse(
        {"error": error, "error_description": "no\x1b[31m" + "x" * 999}, status_code=400
    )
    body = {name: begun[name] for name in ("device_code", "verifier")}
    problem = problem_of(await web.post("/v1/oidc/device-tokens", json=body), 401, "not-authenticated")
    assert error in problem["detail"] and "begin again" in problem["detail"]
    assert "\x1b" not in problem["detail"] and len(problem["detail"]) < 300


@pytest.mark.parametrize(
    "answer",
    [{"user_code": "A"}, {"verification_uri": "javascript:alert(1)"}, {"expires_in": "soon"}],
    ids=["incomplete", "unsafe", "no number"],
)
async def test_a_strange_answer_to_a_device_is_refused(
    web: httpx.AsyncClient, idp: IdentityServer, answer: dict[str, Any]
) -> None:
    whole = {"device_code": "d", "user_code": "u", "verification_uri": idp.issuer, "expires_in": 60}
    idp.answers["device"] = JSONResponse(answer if "user_code" in answer else whole | answer)
    problem_of(await web.post("/v1/oidc/devices"), 503, "unavailable")
