"""Tokens in handshakes and requests.

The kind: secrets in addresses, which servers, proxies and browsers write to logs and histories. Its members are
requests of REST, and the handshakes of our own clients, of the dashboard and of other browsers. Clients of rosbridge
that can send an address alone remain. Of those, many send the user info of an address (``ws://USER:TOKEN@HOST``) as
Basic credentials in the header: websocket-client, Go, JavaScript, curl.
"""

import base64
from collections.abc import Mapping

import pytest
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.authentication import authenticate, authenticate_socket, credentials_of, subprotocol_of
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.tokens import token_id
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated
from storage.memory.store import MemoryStore

PASSWORD = "correct horse"


def handshake(query: str = "", offered: tuple[str, ...] = (), headers: Mapping[str, str] | None = None) -> WebSocket:
    lines = [(name.encode(), value.encode()) for name, value in (headers or {}).items()]
    scope = {
        "type": "websocket",
        "path": "/",
        "query_string": query.encode(),
        "headers": lines,
        "subprotocols": offered,
    }

    async def unused(*_: object) -> dict[str, object]:
        raise AssertionError("no frame is received or sent")

    return WebSocket(scope, unused, unused)


@pytest.fixture
def accounts(clock: ManualClock, passwords: Passwords) -> Accounts:
    return Accounts(MemoryStore(), clock, passwords=passwords)


@pytest.fixture
async def token(accounts: Accounts) -> str:
    await accounts.register("ann", PASSWORD)
    return await accounts.login("ann", PASSWORD)


async def test_a_handshake_may_carry_its_token_in_four_ways(accounts: Accounts, token: str) -> None:
    ticket = await accounts.issue_ticket("ann", token_id(token))
    for socket in (
        handshake(headers={"authorization": f"Bearer {token}"}),
        handshake(offered=("ppaas", f"ppaas.bearer.{token}")),
        handshake(f"robot=tb1&ticket={ticket}"),
        handshake(f"robot=tb1&token={token}"),
    ):
        user, used = await authenticate_socket(socket, accounts)
        assert (user.id, used) == ("ann", token_id(token))


def basic(text: str, scheme: str = "Basic") -> dict[str, str]:
    return {"authorization": f"{scheme} {base64.b64encode(text.encode()).decode()}"}


def request(headers: Mapping[str, str]) -> HTTPConnection:
    lines = [(name.encode(), value.encode()) for name, value in headers.items()]
    return HTTPConnection({"type": "http", "path": "/v1/maps", "query_string": b"", "headers": lines})


@pytest.mark.parametrize("scheme", ["Basic", "basic", "BASIC"])
async def test_user_and_token_of_an_address_come_as_basic_credentials(
    accounts: Accounts, token: str, scheme: str
) -> None:
    headers = basic(f"ann:{token}", scheme)
    user, used = await authenticate_socket(handshake(headers=headers), accounts)
    assert (user.id, used) == ("ann", token_id(token))
    assert (await authenticate(request(headers), accounts)).id == "ann"
    assert credentials_of(request(headers)).token == token


async def test_the_user_of_basic_credentials_must_be_that_of_the_token(accounts: Accounts, token: str) -> None:
    for user in ("bob", "Ann", token):
        headers = basic(f"{user}:{token}")
        with pytest.raises(NotAuthenticated, match="not one of the user named before it") as refused:
            await authenticate_socket(handshake(headers=headers), accounts)
        assert token not in str(refused.value)
        with pytest.raises(NotAuthenticated, match="not one of the user named before it"):
            await authenticate(request(headers), accounts)


async def test_a_password_is_no_token(accounts: Accounts, token: str) -> None:
    with pytest.raises(NotAuthenticated, match="unknown or expired"):
        await authenticate_socket(handshake(headers=basic(f"ann:{PASSWORD}")), accounts)


@pytest.mark.parametrize("text", ["", "ann", ":", "ann:", ":token", "tok\udcff".encode("utf-8", "surrogatepass")])
async def test_basic_credentials_without_user_or_token_are_refused_with_their_form(
    accounts: Accounts, text: str | bytes
) -> None:
    encoded = base64.b64encode(text if isinstance(text, bytes) else text.encode()).decode()
    for value in (encoded, "%%%", "YW5u\u00e9"):
        headers = {"authorization": f"Basic {value}"}
        with pytest.raises(NotAuthenticated, match="must be USER:TOKEN, as in ws://USER:TOKEN@HOST"):
            await authenticate_socket(handshake("token=%20", headers=headers), accounts)
        with pytest.raises(NotAuthenticated, match="must be USER:TOKEN"):
            await authenticate(request(headers), accounts)


async def test_basic_credentials_for_a_proxy_do_not_hide_the_token(accounts: Accounts, token: str) -> None:
    """nginx with ``auth_basic``, for example: the browser sends the proxy's password with each request behind it."""
    ticket = await accounts.issue_ticket("ann", token_id(token))
    for password in ("gate:open sesame", "gate", f"ann:{token[:-1]}"):
        for query, offered in ((f"token={token}", ()), ("", ("ppaas", f"ppaas.bearer.{token}"))):
            user, _ = await authenticate_socket(handshake(query, offered, basic(password)), accounts)
            assert user.id == "ann"
    assert (await authenticate_socket(handshake(f"ticket={ticket}", headers=basic("gate:x")), accounts))[0].id == "ann"


async def test_credentials_of_another_scheme_count_as_none(accounts: Accounts, token: str) -> None:
    socket = handshake(f"token={token}", headers={"authorization": "Negotiate YII="})
    assert (await authenticate_socket(socket, accounts))[0].id == "ann"
    with pytest.raises(NotAuthenticated, match="no token"):
        await authenticate(request({"authorization": "Negotiate YII="}), accounts)


async def test_a_ticket_is_good_for_one_handshake(accounts: Accounts, token: str) -> None:
    ticket = await accounts.issue_ticket("ann", token_id(token))
    await authenticate_socket(handshake(f"ticket={ticket}"), accounts)
    with pytest.raises(NotAuthenticated, match="was used before"):
        await authenticate_socket(handshake(f"ticket={ticket}"), accounts)


async def test_a_ticket_that_is_none_is_refused_whatever_else_is_offered(accounts: Accounts, token: str) -> None:
    for query, offered in ((f"ticket=x&token={token}", ()), ("ticket=x", (f"ppaas.bearer.{token}",))):
        with pytest.raises(NotAuthenticated, match="the ticket is unknown"):
            await authenticate_socket(handshake(query, offered), accounts)


async def test_a_ticket_of_a_revoked_token_is_refused(accounts: Accounts, token: str) -> None:
    ticket = await accounts.issue_ticket("ann", token_id(token))
    await accounts.revoke("ann", token_id(token))
    with pytest.raises(NotAuthenticated, match="log in again"):
        await authenticate_socket(handshake(f"ticket={ticket}"), accounts)


@pytest.mark.parametrize(
    "socket",
    [handshake(), handshake("token=&ticket="), handshake(offered=("ppaas.bearer.",)), handshake("token=%20")],
)
async def test_a_handshake_without_a_token_is_told_each_way(accounts: Accounts, socket: WebSocket) -> None:
    with pytest.raises(NotAuthenticated, match=r"Authorization: Bearer TOKEN.*ws://USER:TOKEN@HOST.*POST /v1/tickets"):
        await authenticate_socket(socket, accounts)


@pytest.mark.parametrize(
    ("offered", "selected"),
    [
        ((), None),
        (("rosbridge",), None),
        (("ppaas.bearer.t", "ppaas"), "ppaas"),
        (("ppaas.bearer.t",), "ppaas.bearer.t"),
    ],
)
def test_a_subprotocol_is_selected_if_a_token_is_offered(offered: tuple[str, ...], selected: str | None) -> None:
    assert subprotocol_of(handshake(offered=offered)) == selected
