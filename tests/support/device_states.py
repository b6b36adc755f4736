"""States of a device, as they come."""

import asyncio
import contextlib


@contextlib.asynccontextmanager
async def running(device):
    """Run a device, whose failure ends the test; yield the states that it has reported so far."""
    states = []
    async with asyncio.TaskGroup() as group:
        task = group.create_task(device.run(states.append))
        yield states
        task.cancel()
