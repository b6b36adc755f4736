"""Tests of services that clients advertise to each other."""

import asyncio

import pytest

from engine.service.links.client_services import MAX_SERVICES, ClientServices
from engine.service.links.open_calls import Outcome
from ppaas.errors import NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable

KIND = "std_srvs/Trigger"


class Provider:
    """Records the calls that it gets."""

    def __init__(self, *, slow: bool = False) -> None:
        self.asked: asyncio.Queue[int] = asyncio.Queue()
        self._slow = slow

    def requested(self, call: int, service: str, payload: bytes) -> None:
        if self._slow:
            raise Unavailable("too slow")
        self.asked.put_nowait(call)


class Caller:
    """Waits for the outcome of one call."""

    def __init__(self, services: ClientServices, timeout: float = 5.0) -> None:
        self.outcomes: asyncio.Queue[Outcome] = asyncio.Queue()
        self.give_up = services.begin("lights", b"{}", timeout, self.outcomes.put_nowait)

    async def outcome(self) -> Outcome:
        """Return the only outcome of the call."""
        async with asyncio.timeout(5):
            outcome = await self.outcomes.get()
        assert self.outcomes.empty()
        return outcome


async def under_way(services: ClientServices, provider: Provider) -> tuple[Caller, int]:
    """Begin a call; return it and its number once the provider has got it."""
    caller = Caller(services)
    return caller, provider.asked.get_nowait()


@pytest.fixture
def provider() -> Provider:
    return Provider()


@pytest.fixture
def services(provider: Provider) -> ClientServices:
    made = ClientServices()
    made.advertise("lights", KIND, 1, provider)
    return made


async def test_a_call_is_answered_once_by_who_was_asked(services: ClientServices, provider: Provider) -> None:
    caller, call = await under_way(services, provider)
    with pytest.raises(NotPermitted):
        services.answer(call, 2, b"{}")
    services.answer(call, 1, b'{"success":true}')
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")
    assert await caller.outcome() == b'{"success":true}'


async def test_a_refusal_is_told_to_the_caller(services: ClientServices, provider: Provider) -> None:
    caller, call = await under_way(services, provider)
    refusal = PPaaSError("no bulb")
    services.answer(call, 1, refusal)
    assert await caller.outcome() is refusal


async def test_a_provider_that_goes_in_the_middle_fails_its_calls(services: ClientServices, provider: Provider) -> None:
    caller, _ = await under_way(services, provider)
    services.leave(2)
    assert caller.outcomes.empty()
    services.leave(1)
    outcome = await caller.outcome()
    assert isinstance(outcome, Unavailable) and "has disconnected" in str(outcome)
    assert services.types() == {}


async def test_a_call_that_takes_too_long_fails_and_its_late_answer_is_told_of(services: ClientServices) -> None:
    outcome = await Caller(services, 0.01).outcome()
    assert isinstance(outcome, Unavailable) and "within 0.01 s" in str(outcome)
    with pytest.raises(NotFound):
        services.answer(1, 1, b"{}")


async def test_of_a_call_that_was_given_up_nobody_hears(services: ClientServices, provider: Provider) -> None:
    caller, call = await under_way(services, provider)
    caller.give_up()
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")
    services.leave(1)
    assert caller.outcomes.empty()


async def test_who_stops_offering_may_still_answer(services: ClientServices, provider: Provider) -> None:
    caller, call = await under_way(services, provider)
    with pytest.raises(NotFound):
        services.unadvertise("lights", 2)
    services.unadvertise("lights", 1)
    assert "lights" not in services and services.type_of("lights") is None
    services.answer(call, 1, b"{}")
    assert await caller.outcome() == b"{}"


async def test_the_newest_provider_takes_a_service_over(services: ClientServices, provider: Provider) -> None:
    older, _ = await under_way(services, provider)
    newer = Provider()
    services.advertise("lights", KIND, 2, newer)
    services.leave(1)
    assert isinstance(await older.outcome(), Unavailable)
    assert services.types() == {"lights": KIND}
    caller, call = await under_way(services, newer)
    services.answer(call, 2, b"{}")
    assert await caller.outcome() == b"{}"


async def test_a_provider_that_cannot_be_asked_fails_the_call_and_not_itself() -> None:
    services = ClientServices()
    services.advertise("lights", KIND, 1, Provider(slow=True))
    with pytest.raises(Unavailable, match="too slow"):
        services.begin("lights", b"{}", 5.0, lambda _: None)
    services.leave(1)


def test_services_are_bounded(services: ClientServices, provider: Provider) -> None:
    for number in range(MAX_SERVICES - 1):
        services.advertise(f"s{number}", KIND, 1, provider)
    with pytest.raises(QuotaExceeded):
        services.advertise("more", KIND, 1, provider)
