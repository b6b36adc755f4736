"""``ppaas doctor`` against a cloud and its robots."""

import json
import re

import msgspec
import pytest

from engine.master.places import robot_key
from ppaas import distribution
from robots.cli import examination
from robots.cli.examination import Examination
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map, robot
from tests.support.world.diagnosed_robot import LINK, healthy


@pytest.fixture
def fleet(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, who has two robots."""
    put_map(ppaas.services.map_store, house("house", owner="ann"))
    for name in ("tb1", "tb2"):
        ppaas.services.store.put_robot(robot(name, user="ann"))
    return ppaas


async def test_robot_that_is_well_ends_with_0(fleet: CommandLine) -> None:
    fleet.cloud.observations = healthy()
    fleet.cloud.presence.came(robot_key("ann", "tb1"))
    ended = await fleet("doctor", "tb1")
    assert (ended.status, ended.err) == (0, "")
    assert ended.out.startswith("tb1: all is well (watched for 5.0 s)\n")
    assert "scan" in ended.out


async def test_findings_are_printed_in_words_and_end_with_1(fleet: CommandLine) -> None:
    fleet.cloud.observations = healthy(link=msgspec.structs.replace(LINK, subscribed=()))
    ended = await fleet("doctor", "tb1", "--seconds", "1")
    assert ended.status == 1
    assert "ERROR  The robot does not subscribe to 'cmd_vel'" in ended.out
    assert fleet.cloud.observed[-1] == ("ann", "tb1", 1.0)


async def test_complete_answer_is_printed_as_json(fleet: CommandLine) -> None:
    fleet.cloud.observations = healthy()
    fleet.cloud.presence.came(robot_key("ann", "tb1"))
    said = json.loads((await fleet("doctor", "tb1", "--json")).out)
    assert (said["robot"], said["level"], said["connected"]) == ("tb1", "ok", True)


async def test_misspelled_robot_is_told_with_the_nearest_one(fleet: CommandLine) -> None:
    ended = await fleet("doctor", "tb11")
    assert ended.status == 1
    assert "Your robots: tb1, tb2. Did you mean 'tb1'?" in ended.out


async def test_cloud_is_examined_with_a_line_for_each_robot(fleet: CommandLine) -> None:
    ended = await fleet("doctor", user="ann")
    assert ended.status == 0
    assert "The token is that of user 'ann'." in ended.out
    assert "Robot 'tb2': it is not connected." in ended.out
    assert "Machines that accept" not in ended.out
    assert "Machines that accept containers: 1" in (await fleet("doctor", user="admin")).out


async def test_robot_in_trouble_is_an_error_of_the_cloud_too(fleet: CommandLine) -> None:
    fleet.cloud.observations = healthy(topics=[])
    ended = await fleet("doctor")
    assert ended.status == 1
    assert "ERROR  Robot 'tb1': No scan has come" in ended.out
    assert "→ See 'ppaas doctor tb1'." in ended.out


async def test_full_cloud_and_a_missing_machine_are_found(fleet: CommandLine) -> None:
    fleet.cloud.known.clear()
    ended = await fleet("doctor", user="admin")
    assert "No machine accepts containers" in ended.out
    assert ended.status == 1


async def test_cloud_that_is_unreachable_and_tokens_that_are_of_no_use_are_told(fleet: CommandLine) -> None:
    for robot_id in (None, "tb1"):
        assert kinds(await report("http://127.0.0.1:1", "x", robot_id)) == ["cloud-unreachable"]
        assert "token" in kinds(await report(fleet.url, None, robot_id))
        assert "token" in kinds(await report(fleet.url, "forged", robot_id))


@pytest.mark.parametrize(("package", "of_a_cloud"), [("websockets", False), ("websockets", True), ("uvicorn", True)])
@pytest.mark.parametrize("words", [["doctor"], ["doctor", "tb1"]], ids=" ".join)
async def test_packages_of_this_computer_that_do_not_fit_come_first(
    fleet: CommandLine, monkeypatch: pytest.MonkeyPatch, package: str, of_a_cloud: bool, words: list[str]
) -> None:
    fleet.cloud.observations = healthy()
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "0.1" if name == package else version(name))
    monkeypatch.setattr(examination, "find_spec", lambda _name: object() if of_a_cloud else None)
    ended = await fleet(*words)
    assert ended.status == 1
    out = " ".join(ended.out.split())  # lines are wrapped
    heading, first = out.split("ERROR ", 1)
    assert re.fullmatch(r"\S+( \S+)?: 1 error(, 1 warning)?( \(watched for .*)? ", heading)
    assert re.match(rf"Packages on this computer .*? {package} 0\.1 \(needed: >=", first)
    assert f"→ Run: pip install '{package}>=" in out


async def test_packages_of_a_cloud_are_nothing_to_a_robot(fleet: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet.cloud.observations = healthy()
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "0.1" if name == "uvicorn" else version(name))
    monkeypatch.setattr(examination, "find_spec", lambda _name: None)
    assert (await fleet("doctor", "tb1")).status == 0


async def report(url: str, token: str | None, robot_id: str | None) -> dict[str, list[dict[str, str]]]:
    examination = Examination(url, token, 0.0)
    return await (examination.cloud() if robot_id is None else examination.robot(robot_id))


def kinds(diagnosis: dict[str, list[dict[str, str]]]) -> list[str]:
    return [finding["kind"] for finding in diagnosis["findings"]]


async def test_time_out_of_range_is_a_usage_error(fleet: CommandLine) -> None:
    assert (await fleet("doctor", "tb1", "--seconds", "9")).status == 2
