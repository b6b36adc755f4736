"""Both peers of a container, over real sockets: its endpoint and its machine."""

import asyncio
from pathlib import Path

from engine.container.container import Container
from engine.container.endpoint_links import EndpointLink
from engine.container.executor import NodeExecutor
from engine.container.machine_client import MachineClient
from engine.container.shared_plans import PlanningNotes
from engine.protocols import machine_link, robot_link
from engine.protocols.refusals import Refusal
from engine.specs.containers import ContainerSpec, Launch
from ppaas.messages import decode
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.nodes.base import Checkpoint
from ppaas.plans.reuse.time_estimates import Times
from tests.support.engine.engine_links import pair, receive
from tests.support.world.echo_node import EchoNode


class ContainerPeers:
    """Endpoint and machine of a container, controlled by the test frame by frame; its node is an ``EchoNode``."""

    def __init__(self, spec: ContainerSpec, path: Path = Path("link.sock")) -> None:
        self.spec = spec
        self._path = path

    async def start(self) -> "ContainerPeers":
        near, self.endpoint = await pair(robot_link.ToContainer, robot_link.FromContainer)
        machine, self.machine = await pair(machine_link.ToContainer, machine_link.FromContainer)
        self.home = NodeExecutor(lambda: None)
        self.node = self.home.graph.add(EchoNode)
        self.home.graph.restore([Checkpoint(name, state) for name, state in self.spec.checkpoint.items()])
        self._client = MachineClient(machine)
        self._near = near
        endpoint = EndpointLink(str(self._path), near)
        self.container = Container(self._launch(), self.home, endpoint, self._client, PlanningNotes(Times()))
        self.serving = asyncio.create_task(self.container.serve())
        self._answers = asyncio.create_task(self._client.serve(lambda _: None))
        return self

    def _launch(self) -> Launch:
        return Launch(self.spec, layers="", link=str(self._path), machine="", secret="secret", cpus=(0,), threads=1)

    async def ask(self, *frames: robot_link.ToContainer) -> robot_link.FromContainer:
        """Send frames, and return the next frame from the container."""
        for frame in frames:
            self.endpoint.write(frame)
        answer: robot_link.FromContainer | None = await receive(self.endpoint)
        assert answer is not None
        return answer

    async def heard(self) -> str:
        """Return what the node received, after it handled all frames sent before."""
        answer = await self.ask(robot_link.ServiceCall(99, "heard", b"{}"))
        assert isinstance(answer, robot_link.ServiceAnswer)
        return decode(TriggerResponse, answer.payload).message

    async def checkpoint(self, refusal: Refusal | None = None) -> dict[str, bytes]:
        """Return the next checkpoint, and confirm it."""
        save = await receive(self.machine)
        assert isinstance(save, machine_link.SaveClone)
        self.machine.write(machine_link.Done(save.request, refusal))
        return save.nodes

    async def close(self) -> None:
        self.serving.cancel()
        self._answers.cancel()
        self.home.close()
        for stream in (self.endpoint, self.machine, self._near):
            await stream.close()
        await self._client.close()


def say(word: str, sequence: int = 0, client: int = 7) -> robot_link.Deliver:
    """Return a message for the node."""
    return robot_link.Deliver("say", b'{"data":"%s"}' % word.encode(), client, sequence)
