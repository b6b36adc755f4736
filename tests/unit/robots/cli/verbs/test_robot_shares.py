"""Tests of ``ppaas robot share`` and ``unshare``."""

import json

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.storage import records


@pytest.fixture(autouse=True)
def _robot(ppaas: CommandLine) -> None:
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    ppaas.services.store.add_user(records.user("dora", groups=("hall",)))


async def test_a_robot_is_shared_listed_and_shared_no_more(ppaas: CommandLine) -> None:
    assert (await ppaas("robot", "share", "tb1")).out.startswith("the robot is not shared; share it: ")
    shared = await ppaas(
        "robot", "share", "tb1", "--with", "bob", "--role", "drive", "--publish", "cmd_vel", "--subscribe", "odom",
        "--subscribe", "map",
    )  # fmt: skip
    assert shared.rows == [["to", "role", "publish", "subscribe"], ["bob", "drive", "cmd_vel", "odom,", "map"]]
    await ppaas("robot", "share", "tb1", "--with", "group:hall", "--role", "look")
    assert [row[0] for row in (await ppaas("robot", "share", "tb1")).rows] == ["to", "bob", "group:hall"]
    assert (await ppaas("robot", "unshare", "tb1", "--with", "group:hall")).status == 0
    listed = json.loads((await ppaas("robot", "share", "tb1", "--json")).out)
    assert listed == [{"to": "bob", "role": "drive", "publish": ["cmd_vel"], "subscribe": ["odom", "map"]}]


async def test_shared_robots_are_listed_and_used_by_their_address(ppaas: CommandLine) -> None:
    assert (await ppaas("robot", "list", "--shared", user="bob")).out == "no robots are shared with you\n"
    await ppaas("robot", "share", "tb1", "--with", "bob", "--role", "look")
    [_, row] = (await ppaas("robot", "list", "--shared", user="bob")).rows
    assert row[:3] == ["ann", "look", "tb1"]
    assert (await ppaas("robot", "show", "ann:tb1", user="bob")).status == 0
    refused = await ppaas("robot", "change", "ann:tb1", "cores=0.5", user="bob")
    assert refused.err == (
        "ppaas: not-permitted: this needs the role 'administer' on robot 'ann:tb1'; you have 'look': ask its owner for "
        "more\n"
    )
    assert (await ppaas("robot", "unshare", "ann:tb1", "--with", "bob", user="bob")).status == 0
    assert (await ppaas("robot", "show", "ann:tb1", user="bob")).err == "ppaas: not-found: unknown robot 'ann:tb1'\n"


@pytest.mark.parametrize(
    ("options", "text"),
    [(["--with", "bob"], "say what for: --role look or"), (["--role", "look"], "say with whom: --with USER")],
)
async def test_missing_options_are_named(ppaas: CommandLine, options: list[str], text: str) -> None:
    ended = await ppaas("robot", "share", "tb1", *options)
    assert (ended.status, text in ended.err) == (1, True)
