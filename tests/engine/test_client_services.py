"""Services that clients offer to one another."""

import asyncio

import pytest

from engine.client_services import MAX_SERVICES, ClientServices
from ppaas.errors import NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable

KIND = "std_srvs/Trigger"


class Provider:
    """Notes what it is asked."""

    def __init__(self, *, slow: bool = False) -> None:
        self.asked: asyncio.Queue[int] = asyncio.Queue()
        self._slow = slow

    def requested(self, call: int, service: str, payload: bytes) -> None:
        if self._slow:
            raise Unavailable("too slow")
        self.asked.put_nowait(call)


async def under_way(services: ClientServices, provider: Provider) -> tuple[asyncio.Task[bytes], int]:
    """Begin a call; return it and its number once the provider was asked."""
    task = asyncio.create_task(services.call("lights", b"{}", 5.0))
    async with asyncio.timeout(5):
        return task, await provider.asked.get()


@pytest.fixture
def provider() -> Provider:
    return Provider()


@pytest.fixture
def services(provider: Provider) -> ClientServices:
    made = ClientServices()
    made.advertise("lights", KIND, 1, provider)
    return made


async def test_a_call_is_answered_once_by_who_was_asked(services: ClientServices, provider: Provider) -> None:
    task, call = await under_way(services, provider)
    with pytest.raises(NotPermitted):
        services.answer(call, 2, b"{}")
    services.answer(call, 1, b'{"success":true}')
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")
    assert await task == b'{"success":true}'
    with pytest.raises(NotFound):
        services.answer(call, 1, b"{}")


async def test_a_refusal_is_told_to_the_caller(services: ClientServices, provider: Provider) -> None:
    task, call = await under_way(services, provider)
    services.answer(call, 1, PPaaSError("no bulb"))
    with pytest.raises(PPaaSError, match="no bulb"):
        await task


async def test_a_provider_that_goes_in_the_middle_fails_its_calls(services: ClientServices, provider: Provider) -> None:
    task, _ = await under_way(services, provider)
    services.leave(2)
    assert not task.done()
    services.leave(1)
    with pytest.raises(Unavailable, match="has gone"):
        await task
    assert services.types() == {}


async def test_a_call_that_takes_too_long_fails_and_its_late_answer_is_told_of(services: ClientServices) -> None:
    with pytest.raises(Unavailable, match=r"within 0\.01 s"):
        await services.call("lights", b"{}", 0.01)
    with pytest.raises(NotFound):
        services.answer(1, 1, b"{}")


async def test_who_stops_offering_may_still_answer(services: ClientServices, provider: Provider) -> None:
    task, call = await under_way(services, provider)
    with pytest.raises(NotFound):
        services.unadvertise("lights", 2)
    services.unadvertise("lights", 1)
    assert "lights" not in services and services.type_of("lights") is None
    services.answer(call, 1, b"{}")
    assert await task == b"{}"


async def test_the_newest_provider_takes_a_service_over(services: ClientServices, provider: Provider) -> None:
    task, call = await under_way(services, provider)
    newer = Provider()
    services.advertise("lights", KIND, 2, newer)
    services.leave(1)
    with pytest.raises(Unavailable):
        await task
    assert services.types() == {"lights": KIND}
    task, call = await under_way(services, newer)
    services.answer(call, 2, b"{}")
    assert await task == b"{}"


async def test_a_provider_that_cannot_be_asked_fails_the_call_and_not_itself() -> None:
    services = ClientServices()
    services.advertise("lights", KIND, 1, Provider(slow=True))
    with pytest.raises(Unavailable, match="too slow"):
        await services.call("lights", b"{}", 5.0)


def test_services_are_bounded(services: ClientServices, provider: Provider) -> None:
    for number in range(MAX_SERVICES - 1):
        services.advertise(f"s{number}", KIND, 1, provider)
    with pytest.raises(QuotaExceeded):
        services.advertise("more", KIND, 1, provider)
