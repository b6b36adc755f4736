"""MCP server of robots, over standard input and output."""

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

from mcp.server.context import ServerRequestContext
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp_types import CallToolRequestParams, CallToolResult, ListToolsResult, PaginatedRequestParams, TextContent

from ppaas import __version__
from ppaas.errors import NotFound, PPaaSError
from robots.mcp import driving, looking
from robots.mcp.narrowed_cloud import NarrowedCloud
from robots.mcp.standard_input import InputLines
from robots.mcp.tool import RobotTool

if TYPE_CHECKING:
    from anyio import AsyncFile

logger = logging.getLogger(__name__)

INSTRUCTIONS = (
    "Mobile robots of a PPaaS cloud. Begin with list_robots. Positions are metres in the frame of a robot's map (x to "
    "the right, y up in map_picture), headings radians counter-clockwise from x. Robots avoid obstacles and zones by "
    "themselves. An error begins with its kind, such as not-permitted: the token does not permit it, so do not repeat "
    "it. A robot that a person has stopped stays stopped until a person releases it."
)


def tools_of(*, read_only: bool, may_release: bool) -> tuple[RobotTool, ...]:
    """Return the tools to offer: those that look alone, and others if they are wanted."""
    effects = {"looks"} if read_only else {"looks", "drives", "stops"}
    if may_release:
        effects.add("releases")
    return tuple(tool for tool in (*looking.TOOLS, *driving.TOOLS) if tool.effect in effects)


class RobotServer:
    """Answers the requests of MCP clients about tools.

    Parameters
    ----------
    cloud : NarrowedCloud
    tools : sequence of RobotTool
        Tools that are offered; others are unknown.
    """

    def __init__(self, cloud: NarrowedCloud, tools: Sequence[RobotTool]) -> None:
        self._cloud = cloud
        self._tools = {tool.name: tool for tool in tools}
        self.mcp: Server[Any] = Server(
            "ppaas",
            title="PPaaS robots",
            version=__version__,
            instructions=INSTRUCTIONS,
            on_list_tools=self._list,
            on_call_tool=self._call,
        )

    async def _list(
        self, _context: ServerRequestContext[Any, Any], _parameters: PaginatedRequestParams | None
    ) -> ListToolsResult:
        return ListToolsResult(tools=[tool.described() for tool in self._tools.values()])

    async def _call(self, context: ServerRequestContext[Any, Any], call: CallToolRequestParams) -> CallToolResult:
        """Run a tool. Its refusal is a result with ``isError``, which the language model reads."""
        try:
            tool = self._tools.get(call.name)
            if tool is None:
                raise NotFound("tool", call.name[:64], list(self._tools))
            return await tool.call(self._cloud, call.arguments or {}, context.session.report_progress)
        except PPaaSError as error:
            return _refused(f"{error.slug}: {error}")
        except Exception:  # a fault of ours: its text may be nothing for a client
            logger.exception("the tool %s failed", call.name[:64])
            return _refused("error: the tool failed; the log of ppaas mcp has the reason")


def _refused(text: str) -> CallToolResult:
    return CallToolResult(content=[TextContent(text=text)], is_error=True)


async def serve(cloud: NarrowedCloud, tools: Sequence[RobotTool]) -> None:
    """Serve one client on standard input and output until it closes standard input."""
    server = RobotServer(cloud, tools).mcp
    lines = cast("AsyncFile[str]", await InputLines.opened())  # of which the library takes the iterator alone
    async with stdio_server(stdin=lines) as (requests, answers):
        await server.run(requests, answers, server.create_initialization_options())
