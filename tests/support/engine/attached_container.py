"""A container that is attached to the container gateway of its machine."""

from engine.agent.container_gateway import ContainerGateway
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec
from tests.support.engine.engine_links import dial_gateway
from tests.support.waiting import until


async def attach_container(gateway: ContainerGateway, spec: ContainerSpec) -> FrameStream[machine_link.ToContainer]:
    """Attach a container to a gateway that expects no other one, and return its end of the link."""
    gateway.expect(spec, "secret")
    stream = await dial_gateway(gateway.path)
    stream.write(machine_link.AttachContainer(spec.id, "secret"))
    await until(lambda: gateway.awaited == 0)
    return stream
