"""Runtime of the bench: its containers are tasks of the agent, so that a thousand of them fit on a computer.

They are the cloud's own containers, with the links and the checkpoints of those, except that a node that answers each
scan takes the place of the clone: what they cost does not depend on planning and driving.
"""

import asyncio
import itertools
import logging
from typing import Any, ClassVar

from engine.container import container as container_module
from engine.container import entry
from engine.runtimes.base import Premises, Runtime
from engine.specs.containers import Launch
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.nodes import topics
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph

logger = logging.getLogger(__name__)

NO_PROCESS = 1 << 22
"""First process id that Linux gives to no process (``pid_max``): the agent then measures no load of containers."""

CHECKPOINTS = 60.0
"""Period of checkpoints without a cause [s]: those of a thousand containers would fill the core of one agent."""

KILLED = -9

VELOCITY = Twist(linear=Vector3(x=0.25), angular=Vector3(z=-0.5))


class Echo(Node):
    """Answers each scan with a velocity."""

    name: ClassVar[str] = "echo"
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.SCAN,)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.CMD_VEL,)

    def on_message(self, topic: str, message: Payload) -> None:
        """Publish a velocity."""
        self.context.publish(topics.CMD_VEL.name, VELOCITY)


def _build(graph: Graph, *_: Any) -> None:
    graph.add(Echo)


class TaskContainer:
    """A container that is a task.

    Parameters
    ----------
    launch : Launch
        Specification of the container.
    pid : int
        Number in place of a process id.
    """

    def __init__(self, launch: Launch, pid: int) -> None:
        self.pid = pid
        self._task = asyncio.create_task(entry.run(launch))

    def kill(self) -> None:
        """End it."""
        self._task.cancel()

    def layers_grew(self) -> None:
        """Do nothing: it sees the folder itself."""

    def endpoint_came(self) -> None:
        """Do nothing: it finds the socket by its name."""

    def resize(self, launch: Launch) -> None:
        """Do nothing: its size limits nothing."""

    async def wait(self) -> int:
        """Wait until it ends; return its exit status."""
        await asyncio.wait({self._task})
        if self._task.cancelled():
            return KILLED
        error = self._task.exception()
        if error is not None:
            logger.error("a container of the bench failed", exc_info=error)
        return int(error is not None)


class EchoRuntime(Runtime):
    """Runs containers as tasks of the agent's event loop."""

    def __init__(self) -> None:
        self._pids = itertools.count(NO_PROCESS)
        self._live: set[TaskContainer] = set()

    @classmethod
    def on(cls, _: Premises) -> "EchoRuntime":
        """Return the runtime of a machine."""
        return cls()

    async def start(self) -> None:
        """Give the containers of this process the graph of the bench."""
        vars(entry)["build_graph"] = _build
        vars(container_module)["CHECKPOINT_PERIOD"] = CHECKPOINTS

    async def launch(self, launch: Launch) -> TaskContainer:
        """Start a container."""
        container = TaskContainer(launch, next(self._pids))
        self._live.add(container)
        return container

    async def close(self) -> None:
        """End all containers."""
        for container in self._live:
            container.kill()
        await asyncio.gather(*(container.wait() for container in self._live))
