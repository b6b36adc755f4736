"""Ray actor that keeps the agent of its node running.

The agent is a child process of the actor, so neither Ray's threads nor its packages get into the fork server of
containers. When the actor dies, the agent exits as well.
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

from engine.local.kept_process import KeptProcess
from engine.processes.instances import folder_of, instance_name
from engine.remote.ray.config import DONE, NodeConfig
from engine.runtimes.memory_tuning import lean_python
from ppaas.decoding import from_json

if TYPE_CHECKING:
    from engine.remote.ray import agent  # noqa: F401

AGENT = "engine.remote.ray.agent"
"""Module of the agent, by name: it is too large to be imported in a Ray worker that only starts it."""

COMMAND = (*lean_python.PYTHON, "-m", AGENT)


def without_ray(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without Ray's variables, such as the token that gives access to its cluster."""
    return {name: value for name, value in environment.items() if not name.startswith("RAY_")}


class AgentActor:
    """Keeps an agent running. Ray calls all methods on one event loop.

    Parameters
    ----------
    config : bytes
        ``NodeConfig`` as JSON, without the fields that only the node itself knows.
    """

    def __init__(self, config: bytes) -> None:
        self._folder = folder_of(instance_name(), Path(tempfile.gettempdir()))
        received = from_json(config, NodeConfig)
        here = msgspec.structs.replace(received, folder=str(self._folder), keeper=os.getpid())
        title = f"agent of machine {here.machine!r}"
        self._agent = KeptProcess(
            title, here, COMMAND, done=DONE, environment=lean_python.environment(without_ray(os.environ))
        )
        self._keeping = asyncio.get_running_loop().create_task(self._keep())

    async def _keep(self) -> None:
        await self._agent.start()
        await self._agent.ended()
        await self._agent.stop()
        await asyncio.to_thread(shutil.rmtree, self._folder, ignore_errors=True)

    async def is_up(self) -> bool:
        """Return true, as soon as the actor runs."""
        return True

    async def live(self) -> None:
        """Run until the agent is not restarted any more. Callers then get Ray's error that the actor has exited."""
        await asyncio.shield(self._keeping)
        ray.actor.exit_actor()  # type: ignore[no-untyped-call]

    async def kill_agent(self) -> None:
        """Kill the agent with all its child processes; it is restarted."""
        self._agent.kill()

    async def stop(self) -> None:
        """Stop the agent, and then the actor."""
        await self._agent.stop()
