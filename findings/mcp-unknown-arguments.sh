#!/usr/bin/env bash
# WITH mcp 2.3.0 from PyPI, Python 3.10 or newer
# EXPECTED A call of a tool with an argument that the tool does not have is an error, as it is in Python, so that a language
#   model learns of its mistake.
# SEEN MCPServer leaves the argument out and calls the tool with its defaults; the schema of the tool permits others, too.
# HERE Arguments are models that forbid others, on the low-level server (robots/mcp/tool.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q mcp==2.3.0; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" <<'PYTHON'
import asyncio
import logging
import sys
from importlib.metadata import version

from mcp import Client
from mcp.server.mcpserver import MCPServer

server = MCPServer("robots")
logging.disable()


@server.tool()
def turn(robot: str, yaw: float = 0.0) -> str:
    """Turn a robot to a heading [rad]."""
    return f"{robot} turns to {yaw:g}"


async def main() -> bool:
    async with Client(server) as client:
        [tool] = (await client.list_tools()).tools
        answer = await client.call_tool("turn", {"robot": "tb1", "yaww": 1.57})
        print(f"mcp {version('mcp')}: yaww=1.57 returns {answer.content[0].text!r}, isError {answer.is_error}")
        return not answer.is_error and "additionalProperties" not in tool.input_schema


sys.exit(not asyncio.run(main()))
PYTHON
