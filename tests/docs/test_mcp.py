"""The commands, options, tools and refusals of mcp.md are those of the code."""

import argparse
import json
import re
import shlex

from ppaas import errors
from robots.cli.command_parser import CommandParser
from robots.cli.commands import token
from robots.mcp import command, driving, looking
from robots.mcp.server import tools_of
from robots.mcp.standard_input import LONGEST
from robots.mcp.tool import MOST_ROWS
from tests.support.documents import blocks, table, text_of

PAGE = "docs/mcp.md"
TEXT = re.sub(r"\s+", " ", text_of(PAGE))


def test_the_commands_are_accepted() -> None:
    [create] = [line for block in blocks(PAGE, "bash") for line in block.splitlines() if "token create" in line]
    parser = CommandParser()
    token.configure(parser)
    parser.parse_args(shlex.split(create)[2:])
    [configuration] = blocks(PAGE, "json")
    server = json.loads(configuration)["mcpServers"]["robots"]
    parser = CommandParser()
    command.configure(parser)
    arguments = parser.parse_args(server["args"][1:])
    assert (server["command"], server["args"][0], arguments.robots) == ("ppaas", "mcp", frozenset({"tb1"}))
    assert list(server["env"]) == ["PPAAS_TOKEN"]


def test_the_options_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    command.configure(parser)
    known = {option for action in parser._actions for option in action.option_strings} - {"-h", "--help"}
    rows = table(PAGE, "option", "meaning")
    assert {option for row in rows for option in re.findall(r"--[a-z-]+", row[0])} == known


def test_the_tools_are_those_of_the_server() -> None:
    rows = {row[0]: row[2] for row in table(PAGE, "tool", "does", "arguments", "needs the role")}
    tools = {tool.name: tool for tool in tools_of(read_only=False, may_release=True)}
    assert list(rows) == list(tools)
    for name, arguments in rows.items():
        assert re.findall(r"\w+", arguments) == list(tools[name].arguments.model_fields), name


def test_the_numbers_and_kinds_are_those_of_the_code() -> None:
    assert f"after `wait` seconds ({driving.DEFAULT_WAIT:g})" in TEXT
    assert LONGEST == 1 << 20 and "Lines of more than 1 MiB are skipped" in TEXT
    assert MOST_ROWS <= 500 and f"paths of {looking.MOST_POSES} poses" in TEXT
    slugs = {error.slug for error in vars(errors).values() if isinstance(error, type) and hasattr(error, "slug")}
    kinds = [row[0].partition(":")[0] for row in table(PAGE, "text", "meaning")]
    assert len(kinds) == 5 and set(kinds) <= slugs
