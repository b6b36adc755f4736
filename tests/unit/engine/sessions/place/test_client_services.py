"""Tests of services that clients advertise to each other."""

import asyncio

import pytest

from engine.links.open_calls import Outcome
from engine.sessions.place.client_services import MAX_SERVICES, ClientServices
from ppaas.errors import NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from tests.support.waiting import patience

KIND = "my_msgs/Lights"


class Provider:
    """Records the calls that it receives."""

    def __init__(self, *, slow: bool = False) -> None:
        self.calls: asyncio.Queue[int] = asyncio.Queue()
        self._slow = slow

    def requested(self, call: int, service: str, payload: bytes) -> None:
        if self._slow:
            raise Unavailable("too slow")
        self.calls.put_nowait(call)


class Caller:
    """Waits for the outcome of one call."""

    def __init__(self, services: ClientServices, timeout: float = 5.0) -> None:
        self.outcomes: asyncio.Queue[Outcome] = asyncio.Queue()
        self.give_up = services.begin("lights", b"{}", timeout, self.outcomes.put_nowait)

    async def outcome(self) -> Outcome:
        """Return the only outcome of the call."""
        async with patience(5):
            outcome = await self.outcomes.get()
        assert self.outcomes.empty()
        return outcome


async def begin_call(services: ClientServices, provider: Provider) -> tuple[Caller, int]:
    """Begin a call; return it and its number after the provider has received it."""
    caller = Caller(services)
    return caller, provider.calls.get_nowait()


@pytest.fixture
def provider() -> Provider:
    return Provider()


@pytest.fixture
def services(provider: Provider) -> ClientServices:
    made = ClientServices()
    made.advertise("lights", KIND, 1, provider)
    return made


async def test_call_is_answered_once_by_its_provider(services: ClientServices, provider: Provider) -> None:
    caller, call = await begin_call(services, provider)
    with pytest.raises(NotPermitted):
        services.answer(call, 2, b"{}")
    services.answer(call, 1, b'{"success":true}')
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")
    assert await caller.outcome() == b'{"success":true}'


async def test_refusal_reaches_the_caller(services: ClientServices, provider: Provider) -> None:
    caller, call = await begin_call(services, provider)
    refusal = PPaaSError("no bulb")
    services.answer(call, 1, refusal)
    assert await caller.outcome() is refusal


async def test_disconnected_provider_fails_its_pending_calls(services: ClientServices, provider: Provider) -> None:
    caller, _ = await begin_call(services, provider)
    services.leave(2)
    assert caller.outcomes.empty()
    services.leave(1)
    outcome = await caller.outcome()
    assert isinstance(outcome, Unavailable) and "has disconnected" in str(outcome)
    assert services.types() == {}


async def test_call_times_out_and_its_late_answer_is_refused(services: ClientServices) -> None:
    outcome = await Caller(services, 0.01).outcome()
    assert isinstance(outcome, Unavailable) and "within 0.01 s" in str(outcome)
    with pytest.raises(NotFound):
        services.answer(1, 1, b"{}")


async def test_abandoned_call_has_no_outcome(services: ClientServices, provider: Provider) -> None:
    caller, call = await begin_call(services, provider)
    caller.give_up()
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")
    services.leave(1)
    assert caller.outcomes.empty()


async def test_unadvertised_service_may_still_answer_pending_calls(
    services: ClientServices, provider: Provider
) -> None:
    caller, call = await begin_call(services, provider)
    with pytest.raises(NotFound):
        services.unadvertise("lights", 2)
    services.unadvertise("lights", 1)
    assert "lights" not in services and services.type_of("lights") is None
    services.answer(call, 1, b"{}")
    assert await caller.outcome() == b"{}"


async def test_newest_provider_takes_over_the_service(services: ClientServices, provider: Provider) -> None:
    older, _ = await begin_call(services, provider)
    newer = Provider()
    services.advertise("lights", KIND, 2, newer)
    services.leave(1)
    assert isinstance(await older.outcome(), Unavailable)
    assert services.types() == {"lights": KIND}
    caller, call = await begin_call(services, newer)
    services.answer(call, 2, b"{}")
    assert await caller.outcome() == b"{}"


async def test_unreachable_provider_fails_the_call_only() -> None:
    services = ClientServices()
    services.advertise("lights", KIND, 1, Provider(slow=True))
    with pytest.raises(Unavailable, match="too slow"):
        services.begin("lights", b"{}", 5.0, lambda _: None)
    services.leave(1)


def test_number_of_services_is_limited(services: ClientServices, provider: Provider) -> None:
    for number in range(MAX_SERVICES - 1):
        services.advertise(f"s{number}", KIND, 1, provider)
    with pytest.raises(QuotaExceeded):
        services.advertise("more", KIND, 1, provider)
