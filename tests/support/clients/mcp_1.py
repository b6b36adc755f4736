"""Client of MCP by the library of 2025 (mcp 1.30): looks, is refused, and drives a robot; prints what it saw as JSON.

``python mcp_1.py '{"server": {...}, "robot": "tb1", "goal": [1.0, 2.0]}'``, with the library in PYTHONPATH.
"""

import asyncio
import json
import sys
from importlib.metadata import version
from typing import Any

from mcp import ClientSession, StdioServerParameters
from mcp.client.stdio import stdio_client


async def main(order: dict[str, Any]) -> None:
    started = StdioServerParameters(**order["server"])
    heard: list[float] = []

    async def progressed(done: float, _total: float | None, _message: str | None) -> None:
        heard.append(done)

    async with stdio_client(started) as streams, ClientSession(*streams) as session:
        hello = await session.initialize()
        tools = (await session.list_tools()).tools
        picture = await session.call_tool("map_picture", {"map": "office", "size": 200})
        refused = await session.call_tool("list_maps", {})
        unknown = await session.call_tool("go_to", {"robot": order["robot"], "x": 1.0, "y": 1.0, "yaww": 1.0})
        x, y = order["goal"]
        goal = await session.call_tool(
            "go_to", {"robot": order["robot"], "x": x, "y": y, "wait": 120.0}, progress_callback=progressed
        )
    found = {
        "library": version("mcp"),
        "protocol": hello.protocolVersion,
        "tools": [tool.name for tool in tools],
        "picture": picture.content[-1].mimeType,
        "refused": refused.content[0].text,
        "unknown": unknown.content[0].text,
        "goal": goal.structuredContent,
        "progress": len(heard),
    }
    sys.stdout.write(json.dumps(found))


asyncio.run(main(json.loads(sys.argv[1])))
