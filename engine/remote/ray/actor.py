"""The actor that keeps the agent of its node running.

The agent is a process of its own below the actor: neither Ray's threads nor its packages get into what containers are
forked from. When the actor dies, the agent ends with it.
"""

import asyncio
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import ray

from engine.local.agent_process import AgentProcess
from engine.processes.instances import folder_of, instance_name
from engine.remote.ray.config import DONE, NodeConfig
from engine.runtimes.memory_tuning import lean_python

if TYPE_CHECKING:
    from engine.remote.ray import agent  # noqa: F401

AGENT = "engine.remote.ray.agent"
"""By its name, since it is too large to be loaded in a Ray worker that only starts it."""

COMMAND = (*lean_python.PYTHON, "-m", AGENT)


def without_ray(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without what is Ray's, such as the token with which its nodes can be told what to do."""
    return {name: value for name, value in environment.items() if not name.startswith("RAY_")}


class AgentActor:
    """Keeps an agent running. Ray calls all of it on one event loop.

    Parameters
    ----------
    config : bytes
        ``NodeConfig`` as JSON, without what only the node itself can say.
    """

    def __init__(self, config: bytes) -> None:
        self._folder = folder_of(instance_name(), Path(tempfile.gettempdir()))
        told = msgspec.json.decode(config, type=NodeConfig)
        here = msgspec.structs.replace(told, folder=str(self._folder), keeper=os.getpid())
        self._agent = AgentProcess(here, COMMAND, done=DONE, environment=without_ray(os.environ))
        self._keeping = asyncio.get_running_loop().create_task(self._keep())

    async def _keep(self) -> None:
        await self._agent.start()
        await self._agent.ended()
        await self._agent.stop()
        await asyncio.to_thread(shutil.rmtree, self._folder, ignore_errors=True)

    async def is_up(self) -> bool:
        """Answer, which it cannot before it runs."""
        return True

    async def live(self) -> None:
        """Go on until the agent is started no more; that the actor ended is told by Ray to whoever asked."""
        await asyncio.shield(self._keeping)
        ray.actor.exit_actor()  # type: ignore[no-untyped-call]

    async def kill_agent(self) -> None:
        """End the agent by force, with what it started: it is started again."""
        self._agent.kill()

    async def stop(self) -> None:
        """End the agent, and then the actor."""
        await self._agent.stop()
