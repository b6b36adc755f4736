"""The client advertises the services of local nodes while they run on the robot."""

import msgspec
import pytest

from ppaas.errors import Conflict, Unavailable
from ppaas.messages import ServiceType
from ppaas.messages.base.message import Empty
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from robots.client.services import Handler
from robots.onboard.executor import protocol
from robots.onboard.node_bridge import NodeServices

ADDED = protocol.Added(
    "move_base",
    [],
    [],
    [protocol.ServiceName("count", "std_srvs/Trigger"), protocol.ServiceName("horn", "std_srvs/Empty")],
)


class FakeClient:
    """Records the advertised services."""

    def __init__(self) -> None:
        self.handlers: dict[str, Handler] = {}

    async def advertise_service(self, service: str, kind: ServiceType, handler: Handler) -> None:
        if service in self.handlers:
            raise Conflict(f"this client offers {service} already")
        self.handlers[service] = handler

    async def unadvertise_service(self, service: str) -> None:
        del self.handlers[service]


class FakeProcess:
    """Answers with the number of calls until it exits."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, bytes]] = []
        self.gone = False

    async def call(self, service: str, request: bytes) -> msgspec.Raw:
        self.asked.append((service, request))
        if self.gone:
            raise Unavailable("it is gone")
        return msgspec.Raw(b'{"success": true, "message": "%d"}' % len(self.asked))


async def test_services_of_a_local_node_are_advertised_and_answered() -> None:
    client, process = FakeClient(), FakeProcess()
    services = NodeServices(client)  # type: ignore[arg-type]
    await services.open(ADDED, process)  # type: ignore[arg-type]
    assert list(client.handlers) == ["count", "horn"]
    answer = client.handlers["count"](Empty())
    assert not isinstance(answer, TriggerResponse)
    assert await answer == Trigger.response(True, "1")
    assert process.asked == [("count", b"{}")]
    process.gone = True
    with pytest.raises(Unavailable, match="it is gone"):
        await client.handlers["count"](Empty())  # type: ignore[misc]
    await services.close("move_base")
    await services.close("move_base")
    assert client.handlers == {}


async def test_a_service_that_the_robot_advertises_itself_is_kept(caplog: pytest.LogCaptureFixture) -> None:
    client, process = FakeClient(), FakeProcess()
    services = NodeServices(client)  # type: ignore[arg-type]
    await client.advertise_service("horn", Trigger, lambda _: TriggerResponse(True))
    await services.open(ADDED, process)  # type: ignore[arg-type]
    assert "a service of move_base is not available on the robot" in caplog.text
    await services.close("move_base")
    assert list(client.handlers) == ["horn"]
