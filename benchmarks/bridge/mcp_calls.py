"""Cost of calls of the MCP server, one after the other, beside the same requests of REST without it."""

import asyncio
import os
import sys

import psutil
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from benchmarks.bridge import bare_calls
from benchmarks.bridge.measurement import CloudStandIn, cloud_stand_in
from benchmarks.harness.figures import Figure
from benchmarks.harness.process_usage import cpu_of
from ppaas.clock import monotonic
from robots import cli

PART = "mcp"
CALLS, QUICK_CALLS = 500, 20

MOST_ADDED = 5.0
"""Limit of the CPU time that a call takes beyond its request of REST [ms]: a person or a model waits for seconds."""

GOAL = {"robot": "robot", "goal": "goal"}


async def measure_calls(*, quick: bool) -> list[Figure]:
    """Return the figures."""
    count = QUICK_CALLS if quick else CALLS
    async with cloud_stand_in() as cloud:
        bare, bare_used = await _bare(cloud, count)
        taken, used, memory = await _served(cloud, count)
    most = round(1e3 * bare_used + MOST_ADDED, 2)
    return [
        Figure(PART, "a request of REST", round(1e3 * bare, 2), "ms", yardstick=True, note="one after the other"),
        Figure(PART, "CPU time of a request of REST", round(1e3 * bare_used, 2), "ms", yardstick=True),
        Figure(PART, "a call of goal_state", round(1e3 * taken, 2), "ms"),
        Figure(PART, "CPU time of a call", round(1e3 * used, 2), "ms", limit=most, note="that of REST and 5 ms"),
        Figure(PART, "calls in a second", round(1.0 / taken, 1), "Hz"),
        Figure(PART, "memory", round(memory, 1), "MB"),
    ]


async def _bare(cloud: CloudStandIn, count: int) -> tuple[float, float]:
    """Return the time and the CPU time of a request [s]."""
    command = ["-m", bare_calls.__name__, cloud.url, "/v1/robots/robot/goals/goal", str(count)]
    process = await asyncio.create_subprocess_exec(sys.executable, *command, stdout=asyncio.subprocess.PIPE)
    written, _ = await process.communicate()
    taken, used = map(float, written.split())
    return taken, used


async def _served(cloud: CloudStandIn, count: int) -> tuple[float, float, float]:
    """Return the time and the CPU time of a call [s], and the memory of the server [MB]."""
    paths = {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = ["-m", cli.__name__, "mcp", "--read-only", "--url", cloud.url, "--token", "t"]
    own = {child.pid for child in psutil.Process().children()}
    async with Client(stdio_client(StdioServerParameters(command=sys.executable, args=command, env=paths))) as client:
        await client.call_tool("goal_state", GOAL)
        [server] = [child for child in psutil.Process().children() if child.pid not in own]
        began, before = monotonic(), cpu_of(server)
        for _ in range(count):
            answer = await client.call_tool("goal_state", GOAL)
        taken, used = monotonic() - began, cpu_of(server) - before
        assert not answer.is_error, answer
        return taken / count, used / count, server.memory_info().rss / 1e6
