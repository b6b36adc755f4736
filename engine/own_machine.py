"""The machines that a cloud has started itself: this one, or the nodes of a Ray cluster (``engine.ray_nodes``)."""

from typing import Protocol

from engine.agent_config import AgentConfig
from engine.agent_process import AgentProcess


class Agents(Protocol):
    """What keeps the agents of the machines that a cloud has started itself."""

    come_at_once: bool
    """Tell whether there is a machine for sure, so that the start of a cloud waits for it."""

    async def start(self) -> None:
        """Start the agents, and go on starting them."""
        ...

    def kill(self, machine: str) -> None:
        """End the agent of a machine by force, if it is one of these: it is frozen, and is started again."""
        ...

    async def stop(self) -> None:
        """End all agents."""
        ...


class OwnMachine:
    """Keeps the agent of this machine.

    Parameters
    ----------
    config : AgentConfig
        What it is told.
    """

    come_at_once = True

    def __init__(self, config: AgentConfig) -> None:
        self._name = config.machine
        self._agent = AgentProcess(config)

    async def start(self) -> None:
        """Start the agent, and go on starting it."""
        await self._agent.start()

    def kill(self, machine: str) -> None:
        """End the agent by force if it is of that machine.

        Of one on another host no more is heard when it is frozen, and it does nothing by then.
        """
        if machine == self._name:
            self._agent.kill()

    async def stop(self) -> None:
        """End the agent."""
        await self._agent.stop()
