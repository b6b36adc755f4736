"""Local node managers for tests."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.node_manager import LocalNodes
from tests.support.waiting import patience, until

WEAK = Computer(4, 1.5, 1.0)
ABLE = Computer(4, 2.0, 2.2)
ASK_AGAIN, GIVE_UP = 10.0, 120.0
"""Time before a request is repeated, and before the test fails [s]."""


@asynccontextmanager
async def managing(client: RobotClient, computer: Computer, **options: Any) -> AsyncIterator[LocalNodes]:
    """Run a local node manager beside a client."""
    manager = LocalNodes(client, computer, **options)
    running = asyncio.create_task(manager.run())
    ready = asyncio.create_task(manager.ready.wait())
    await asyncio.wait({running, ready}, timeout=30, return_when=asyncio.FIRST_COMPLETED)
    assert ready.done() and not running.done(), running
    try:
        yield manager
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


async def take_over(manager: LocalNodes, *nodes: str) -> None:
    """Move nodes to the robot; repeat the request if the cloud takes them back from a busy computer."""
    async with patience(GIVE_UP):
        while manager.running != set(nodes):
            for node in nodes:
                assert (await manager.ask(node, "robot")).wanted == "robot"
            with contextlib.suppress(TimeoutError):
                await until(lambda: manager.running == set(nodes), ASK_AGAIN)
