"""Logouts that an identity provider reports (OpenID Connect Back-Channel Logout 1.0): honest ones, and lies."""

import time

import httpx
import pytest
from starlette.responses import Response

from endpoints.audit.event import AuditQuery
from endpoints.oidc.settings import OidcSettings
from endpoints.resources.services import Services
from ppaas.clock import ManualClock
from storage.sharing_records import TokenScope
from tests.support.endpoints.problems import problem_of
from tests.support.identity.identity_server import CLIENT, IdentityServer, new_key
from tests.unit.endpoints.conftest import LogIn
from tests.unit.endpoints.rest.users.conftest import Open
from tests.unit.endpoints.rest.users.test_oidc import by_browser


async def log_out(web: httpx.AsyncClient, token: str) -> httpx.Response:
    return await web.post("/v1/oidc/logouts", data={"logout_token": token})


async def is_in(web: httpx.AsyncClient, login: httpx.Response) -> bool:
    answer = await web.get("/v1/users/me", headers={"Authorization": f"Bearer {login.json()['token']}"})
    return answer.status_code == 200


@pytest.fixture
def clock() -> ManualClock:
    """Return a clock of the cloud beside the one of the provider: the order of logins and logouts counts."""
    return ManualClock(time.time())


async def test_a_logout_of_a_session_ends_its_tokens_alone(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services
) -> None:
    first, other, unnamed = [await log_in_at(web, idp, session) for session in ("s1", "s2", None)]
    ended = await log_out(web, idp.logout_token(sid="s1"))
    assert (ended.status_code, ended.content, ended.headers["cache-control"]) == (200, b"", "no-store")
    assert [await is_in(web, login) for login in (first, other, unnamed)] == [False, True, True]
    [event] = services.audit.read(AuditQuery(action="end_provider_sessions"))
    assert event.details == {"subject": "id-of-ann", "session": True, "tokens": {"ann": 1}}


async def test_a_logout_of_a_person_ends_all_logins_with_the_provider(
    web: httpx.AsyncClient, idp: IdentityServer, services: Services, log_in: LogIn
) -> None:
    logins = [await log_in_at(web, idp, session) for session in ("s1", None)]
    scoped = await services.accounts.issue_scoped("ann", TokenScope(("*",), "look"), 60.0)
    bob = await log_in("bob")
    idp.person.subject, idp.person.claims["preferred_username"] = "id-of-eve", "eve"
    eve = await log_in_at(web, idp, "s3")
    assert (await log_out(web, idp.logout_token(sub="id-of-ann"))).status_code == 200
    assert [await is_in(web, login) for login in (*logins, eve)] == [False, False, True]
    assert (await services.accounts.authenticate(scoped.token)).id == "ann", "robots do not stop"
    assert (await web.get("/v1/users/me", headers=bob)).status_code == 200


async def test_a_logout_of_a_linked_user_leaves_logins_with_the_password(
    web: httpx.AsyncClient, idp: IdentityServer, log_in: LogIn
) -> None:
    admin, by_password = await log_in("admin"), await log_in("ann")
    identity = {"issuer": idp.issuer, "subject": "id-of-ann"}
    await web.patch("/v1/users/ann", json={"identity": identity}, headers=admin)
    login = await log_in_at(web, idp, "s1")
    assert (await log_out(web, idp.logout_token())).status_code == 200
    assert not await is_in(web, login)
    assert (await web.get("/v1/users/me", headers=by_password)).status_code == 200


async def test_a_session_is_found_without_its_person(web: httpx.AsyncClient, idp: IdentityServer) -> None:
    ann = await log_in_at(web, idp, "s1")
    idp.person.subject, idp.person.claims["preferred_username"] = "id-of-eve", "eve"
    eve = await log_in_at(web, idp, "s2")
    assert (await log_out(web, idp.logout_token(sub=None, sid="s2"))).status_code == 200
    assert [await is_in(web, login) for login in (ann, eve)] == [True, False]


async def test_a_report_that_is_sent_again_ends_no_later_session(
    web: httpx.AsyncClient, idp: IdentityServer, clock: ManualClock
) -> None:
    report = idp.logout_token()
    clock.advance(90.0)
    login = await log_in_at(web, idp, None)
    for _ in range(2):
        assert (await log_out(web, report)).status_code == 200
    assert await is_in(web, login)


async def test_a_logout_of_somebody_unknown_is_taken(web: httpx.AsyncClient, idp: IdentityServer) -> None:
    assert (await log_out(web, idp.logout_token(sub="nobody here"))).status_code == 200


async def test_a_lie_about_a_logout_ends_nothing(web: httpx.AsyncClient, idp: IdentityServer) -> None:
    login = await log_in_at(web, idp, "s1")
    forged = idp.signed({"iss": idp.issuer, "sub": "id-of-ann"}, new_key("first"))
    others = {"aud": "x", "iss": "https://evil.example", "events": {}, "nonce": "n", "exp": 1}
    lies = [idp.logout_token(**{name: value}) for name, value in others.items()]
    for token in (forged, "x", "a.b.c", idp.token(CLIENT), *lies):
        problem_of(await log_out(web, token), 400, "invalid-input")
    assert await is_in(web, login)


async def test_what_is_no_form_of_one_token_is_refused(web: httpx.AsyncClient, idp: IdentityServer) -> None:
    url, form = "/v1/oidc/logouts", {"Content-Type": "application/x-www-form-urlencoded"}
    problem_of(await web.post(url, json={"logout_token": "x"}), 415, "unsupported-media-type")
    for body in (b"", b"logout_token=", b"logout_token=a&logout_token=b", b"other=1"):
        problem_of(await web.post(url, content=body, headers=form), 400, "invalid-input")
    for body in (b"\xff", b"&".join([b"a=1"] * 99)):
        problem_of(await web.post(url, content=body, headers=form), 400, "malformed-message")


async def test_a_logout_while_the_provider_is_away_is_tried_again_by_it(
    opened: Open, settings: OidcSettings, idp: IdentityServer
) -> None:
    idp.answers["keys"] = Response(status_code=500)
    web = await opened(settings)
    problem_of(await log_out(web, idp.logout_token()), 503, "unavailable")


async def log_in_at(web: httpx.AsyncClient, idp: IdentityServer, session: str | None) -> httpx.Response:
    """Log in within a session at the provider."""
    idp.person.claims.pop("sid", None)
    if session is not None:
        idp.person.claims["sid"] = session
    login = await by_browser(web)
    assert login.status_code == 201, login.text
    return login
