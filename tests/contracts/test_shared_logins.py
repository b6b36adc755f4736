"""The contract of `SharedLogins`: of those in this process, and of those whose calls are messages."""

from typing import Any, get_type_hints

import msgspec
import pytest

from endpoints.accounts.fair_queue import RequestOrigin
from endpoints.accounts.shared_logins import MAX_UNSAVED, USER_AT_ADDRESS, LocalLogins, SharedLogins
from endpoints.accounts.socket_tickets import LIFETIME
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated, TooManyAttempts
from storage.records import Token
from storage.sharing_records import TokenScope

TOKEN = Token("a" * 64, "ann", 100.0, 1.0, TokenScope(("tb*",), "look"), "a shelf")


class EncodedLogins:
    """Logins of which each argument and result is encoded as MessagePack and decoded, as between two processes."""

    def __init__(self, logins: LocalLogins) -> None:
        self._logins = logins

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._logins, name)
        hints = get_type_hints(method)
        result = hints.pop("return")

        async def call(*arguments: object) -> Any:
            sent = msgspec.msgpack.encode(arguments)
            received = msgspec.msgpack.decode(sent, type=tuple[tuple(hints.values())[: len(arguments)]])
            answer = msgspec.msgpack.encode(await method(*received))
            return msgspec.msgpack.decode(answer, type=result)

        return call


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture(params=["local", "encoded"])
def logins(request: pytest.FixtureRequest, clock: ManualClock) -> SharedLogins:
    local = LocalLogins(clock)
    return EncodedLogins(local) if request.param == "encoded" else local  # type: ignore[return-value]


async def fail(logins: SharedLogins, times: int) -> RequestOrigin:
    for _ in range(times):
        origin = await logins.admit("ann", "10.0.0.1")
        await logins.failed(origin)
    return origin


async def test_failures_are_counted_until_the_next_attempt_waits(logins: SharedLogins, clock: ManualClock) -> None:
    origin = await fail(logins, USER_AT_ADDRESS.failures - 1)
    assert origin == RequestOrigin("ann", "10.0.0.1", known=False, kind="password")
    assert await logins.failed(origin) == USER_AT_ADDRESS.failures
    with pytest.raises(TooManyAttempts) as refused:
        await logins.admit("ann", "10.0.0.1")
    assert refused.value.retry_after == USER_AT_ADDRESS.first
    clock.advance(USER_AT_ADDRESS.first)
    await logins.succeeded(await logins.admit("ann", "10.0.0.1"))
    assert (await logins.admit("ann", "10.0.0.1")).known


async def test_each_kind_of_login_is_counted_on_its_own(logins: SharedLogins) -> None:
    await fail(logins, USER_AT_ADDRESS.failures)
    robot = await logins.admit("ann", "10.0.0.1", "rapyuta")
    assert robot.kind == "rapyuta"
    await logins.succeeded(robot)
    with pytest.raises(TooManyAttempts):
        await logins.admit("ann", "10.0.0.1")
    assert await logins.failed(robot) == 1


async def test_a_ticket_is_redeemed_once_and_in_time(logins: SharedLogins, clock: ManualClock) -> None:
    used, late = [await logins.issue_ticket("ann", name) for name in ("hash 1", "hash 2")]
    assert await logins.redeem_ticket(used) == "hash 1"
    clock.advance(LIFETIME)
    for ticket in (used, late, "unknown", ""):
        with pytest.raises(NotAuthenticated):
            await logins.redeem_ticket(ticket)


async def test_a_kept_token_is_found_until_it_is_dropped(logins: SharedLogins) -> None:
    await logins.keep_token(TOKEN)
    assert await logins.kept_token(TOKEN.hash) == TOKEN
    assert await logins.drop_token(TOKEN.hash)
    assert await logins.kept_token(TOKEN.hash) is None
    assert not await logins.drop_token(TOKEN.hash)


async def test_the_kept_tokens_of_a_user_are_dropped_except_one(logins: SharedLogins) -> None:
    tokens = [Token(name, user, 100.0) for name, user in (("t1", "ann"), ("t2", "ann"), ("t3", "bob"))]
    for token in tokens:
        await logins.keep_token(token)
    await logins.drop_tokens("ann", "t2")
    assert [await logins.kept_token(token.hash) for token in tokens] == [None, *tokens[1:]]
    await logins.drop_tokens("ann", None)
    assert [await logins.kept_token(token.hash) for token in tokens] == [None, None, tokens[2]]


async def test_of_many_kept_tokens_the_oldest_are_forgotten(logins: SharedLogins) -> None:
    for number in range(MAX_UNSAVED + 1):
        await logins.keep_token(Token(f"t{number}", "ann", 100.0))
    assert await logins.kept_token("t0") is None
    assert await logins.kept_token("t1") is not None


async def test_a_refused_token_is_one_of_a_user(logins: SharedLogins) -> None:
    await logins.refuse_token("ann", "t1")
    assert [await logins.is_refused(*key) for key in (("ann", "t1"), ("bob", "t1"), ("ann", "t2"))] == [
        True,
        False,
        False,
    ]
    await logins.removed_token("ann", "t1")
    await logins.removed_token("ann", "t1")
    assert await logins.is_refused("ann", "t1"), "an endpoint may just be reading it"


async def test_all_listeners_hear_of_a_changed_user(clock: ManualClock) -> None:
    local, heard = LocalLogins(clock), list[str]()
    local.on_forget(heard.append)
    local.on_forget(heard.append)
    await EncodedLogins(local).forget("ann")
    assert heard == ["ann", "ann"]
