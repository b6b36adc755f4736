"""Tools of the MCP server: name, effect, JSON schemas of arguments and answers, and the function that does it."""

import json
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from mcp_types import CallToolResult, ContentBlock, TextContent, Tool, ToolAnnotations
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ppaas.errors import InvalidInput
from ppaas.geometry import FARTHEST
from robots.mcp.narrowed_cloud import NarrowedCloud

_NAME = "[A-Za-z0-9][A-Za-z0-9_.-]{0,63}"

RobotAddress = Annotated[
    str, Field(pattern=f"^({_NAME}:)?{_NAME}$", description="Id of the robot; OWNER:ID for one of another user")
]
MapName = Annotated[str, Field(pattern=f"^{_NAME}$", description="Id of the map, as list_robots shows it")]
GoalName = Annotated[str, Field(pattern=f"^{_NAME}$", description="Id of the goal, as go_to returns it")]
Metres = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Radians = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]

MOST_ROWS = 100
"""Rows of a list that are returned by default."""

Rows = Annotated[int, Field(ge=1, le=500, description="Largest number of rows")]

Effect = Literal["looks", "drives", "stops", "releases"]

Progress = Callable[[float, float, str], Awaitable[None]]
"""Reports to the client: what is done, of how much, and a text."""


class Arguments(BaseModel):
    """Base of the arguments of a tool: unknown ones, numbers as text and numbers that are not finite are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class Answer(BaseModel):
    """Base of the answers of tools: fields of the cloud's answers that a newer cloud adds are left out."""

    model_config = ConfigDict(extra="ignore")


Answered = Answer | Sequence[ContentBlock]
"""What a tool returns: an answer with a schema, or content, such as a picture."""


@dataclass(frozen=True, slots=True)
class RobotTool:
    """A tool.

    Parameters
    ----------
    name, title, text : str
        Its name; its name for people; what it does, for the language model.
    effect : str
        ``looks`` changes nothing; ``drives`` and ``stops`` a robot, or ``releases`` one.
    arguments : type of Arguments
    answer : type of Answer, optional
        None if it returns content.
    run : callable
        Takes the cloud, the arguments, and a function that reports progress.
    """

    name: str
    title: str
    text: str
    effect: Effect
    arguments: type[Arguments]
    answer: type[Answer] | None
    run: Callable[[NarrowedCloud, Any, Progress], Awaitable[Answered]]

    def described(self) -> Tool:
        """Return its description, as clients list it."""
        return Tool(
            name=self.name,
            title=self.title,
            description=self.text,
            input_schema=self.arguments.model_json_schema(),
            output_schema=None if self.answer is None else self.answer.model_json_schema(mode="serialization"),
            annotations=ToolAnnotations(
                read_only_hint=self.effect == "looks",
                destructive_hint=self.effect in ("drives", "releases"),
                idempotent_hint=self.effect != "drives",
                open_world_hint=False,
            ),
        )

    async def call(self, cloud: NarrowedCloud, arguments: dict[str, Any], progress: Progress) -> CallToolResult:
        """Check the arguments, and run the tool.

        Raises
        ------
        InvalidInput
            The arguments do not match the schema; the text names each fault.
        PPaaSError
            The refusal of the cloud.
        """
        try:
            checked = self.arguments.model_validate(arguments)
        except ValidationError as error:
            raise InvalidInput(f"{self.name}: {_faults(error)}") from error
        answered = await self.run(cloud, checked, progress)
        if not isinstance(answered, Answer):
            return CallToolResult(content=list(answered))
        structured = answered.model_dump(mode="json")
        text = TextContent(text=json.dumps(structured, ensure_ascii=False))
        return CallToolResult(content=[text], structured_content=structured)


def _faults(error: ValidationError) -> str:
    """Return the faults of arguments, each with its place; not the values, which may be long."""
    faults = error.errors(include_url=False, include_context=False, include_input=False)
    return "; ".join(f"{'.'.join(map(str, fault['loc']))[:64]}: {fault['msg']}" for fault in faults[:10])
