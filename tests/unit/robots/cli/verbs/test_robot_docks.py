"""Tests of ``ppaas robot dock`` and ``undock``."""

import pytest

from robots.cli.command_parser import CommandParser
from robots.cli.verbs import robot_docks
from tests.support.cloud.command_line import CommandLine
from tests.support.storage import records


@pytest.mark.parametrize("verb", ["dock", "undock"])
async def test_a_robot_that_is_not_connected_is_to_be_started(ppaas: CommandLine, verb: str) -> None:
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    refused = await ppaas("robot", verb, "tb1")
    assert (refused.status, refused.out) == (1, "")
    assert "robot 'tb1' is not connected: start it, and try again" in refused.err
    assert "unknown" in (await ppaas("robot", verb, "tb9")).err


def test_a_dock_is_named_or_given_by_its_pose() -> None:
    parser = CommandParser()
    robot_docks.configure_dock(parser)
    named = parser.parse_args(["tb1", "home"])
    assert (named.id, named.dock, named.pose) == ("tb1", "home", None)
    placed = parser.parse_args(["tb1", "--pose", "1", "2", "1.57", "--type", "v_shape"])
    assert (placed.dock, placed.pose, placed.type) == ("", [1.0, 2.0, 1.57], "v_shape")
    with pytest.raises(SystemExit):
        parser.parse_args(["tb1", "--pose", "1", "2"])
