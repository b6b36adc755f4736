"""Command ``ppaas demo``, with one complete run."""

import argparse
import asyncio
import json
from pathlib import Path

import psutil
import pytest
from rich.console import Console

from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter, Unavailable
from robots.cli.command_parser import CommandParser
from robots.cli.commands import demo
from robots.client.map_files import read_map_file
from robots.demo.cloud_process import CloudProcess
from tests.support.sources import ROOT
from tests.support.waiting import patience


def children() -> set[psutil.Process]:
    """Return the child processes; some may be shared with other tests."""
    return set(psutil.Process().children())


def parse(*arguments: str) -> argparse.Namespace:
    parser = CommandParser()
    demo.configure(parser)
    return parser.parse_args(list(arguments))


def test_defaults_show_three_robots() -> None:
    arguments = parse()
    assert (arguments.robots, arguments.map, arguments.headless, arguments.json) == (3, None, False, False)


@pytest.mark.parametrize("arguments", [("--robots", "0"), ("--goals", "-1"), ("--robots", "x")])
def test_invalid_counts_are_refused(arguments: tuple[str, ...]) -> None:
    with pytest.raises(SystemExit):
        parse(*arguments)


def test_keep_going_requires_a_terminal() -> None:
    with pytest.raises(InvalidParameter, match="terminal"):
        demo.run(parse("--keep-going"))


@pytest.mark.parametrize("arguments", [("--robots", "2"), ("--goals", "1")])
def test_exploring_has_its_own_robots_and_goals(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="--explore has its own robots and goals"):
        demo.run(parse("--explore", *arguments))


@pytest.mark.parametrize("arguments", [("--explorers", "2"), ("--explore", "--explorers", "5")])
def test_several_robots_explore_only_where_exploring_is_shown(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="--explorers goes with --explore, and must be 1 to 4"):
        demo.run(parse(*arguments))


@pytest.mark.parametrize("arguments", [("--explore",), ("--goals", "1")])
def test_people_go_without_goals_and_explorers(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="leave out --goals and --explore"):
        demo.run(parse("people", *arguments))


def test_a_fleet_goes_without_explorers() -> None:
    with pytest.raises(InvalidParameter, match="leave out --explore"):
        demo.run(parse("fleet", "--explore"))


@pytest.mark.parametrize("arguments", [("--explore",), ("--map", "office.yaml")])
def test_a_building_goes_without_explorers_and_makes_its_maps(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="leave out --explore and --map"):
        demo.run(parse("building", *arguments))


@pytest.mark.parametrize("arguments", [("--people", "2"), ("--sensor", "laser"), ("--explore", "--seconds", "5")])
def test_options_of_the_demo_of_people_are_refused_elsewhere(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="run 'ppaas demo people'"):
        demo.run(parse(*arguments))


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="--seed"):
        demo.run(parse("--seed=-1"))


def test_a_missing_map_is_refused_before_a_cloud_starts(tmp_path: Path) -> None:
    before = children()
    with pytest.raises(InvalidMap, match=r"nowhere\.yaml"):
        demo.run(parse("--headless", "--map", str(tmp_path / "nowhere.yaml")))
    assert children() <= before


def test_a_map_is_named_after_its_file() -> None:
    file = ROOT / "docs" / "examples" / "office.yaml"
    options = demo._options(parse("--map", str(file)), Console())
    assert options.map is not None
    map_id, grid = options.map
    assert (map_id, grid.data.tolist()) == ("office", read_map_file(file).data.tolist())


async def test_a_cloud_that_fails_to_start_reports_why_and_leaves_nothing() -> None:
    cloud = CloudProcess()
    folder = cloud.folder
    (folder / "password").mkdir()
    with pytest.raises(
        Unavailable, match=r"the cloud exited with status 1:\n(.*\n)*.*cannot read or create the password file"
    ):
        async with cloud:
            pytest.fail("it started")
    assert not folder.exists()


async def test_the_cloud_of_a_demo_takes_no_settings_of_a_cloud_of_this_host(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ppaas.toml").write_text("[up]\nport = 'wrong'\n")
    monkeypatch.setenv("PPAAS_CONFIG", str(tmp_path / "ppaas.toml"))
    cloud = CloudProcess()
    (cloud.folder / "password").mkdir()  # ends the start, after settings were read
    with pytest.raises(Unavailable, match="cannot read or create the password file"):
        async with cloud:
            pytest.fail("it started")


async def test_a_cloud_in_a_folder_of_its_caller_leaves_its_files(tmp_path: Path) -> None:
    cloud = CloudProcess(folder=tmp_path, arguments=("--port", "none"))
    with pytest.raises(Unavailable, match="the cloud exited with status 2"):
        async with cloud:
            pytest.fail("it started")
    assert "--port" in (tmp_path / "log").read_text()


@pytest.mark.journey
async def test_cancelling_the_start_of_a_cloud_leaves_nothing() -> None:
    cloud = CloudProcess()
    before = children()
    entering = asyncio.create_task(cloud.__aenter__())
    async with patience(30):
        while children() <= before:
            await asyncio.sleep(0.01)
    started = [child for process in children() - before for child in (process, *process.children(recursive=True))]
    entering.cancel()
    with pytest.raises(asyncio.CancelledError):
        await entering
    assert not cloud.folder.exists()
    _, alive = psutil.wait_procs(started, 10)
    assert not alive


@pytest.mark.journey
def test_two_robots_reach_their_goals_without_contact(capsys: pytest.CaptureFixture[str]) -> None:
    before = children()
    status = demo.run(parse("--headless", "--robots", "2", "--goals", "1", "--seed", "4", "--json"))
    [line] = capsys.readouterr().out.splitlines()
    report = json.loads(line)
    assert status == 0
    assert report["map"] == "warehouse"
    assert [robot["id"] for robot in report["robots"]] == ["turtlebot-1", "turtlebot-2"]
    for robot in report["robots"]:
        assert (robot["goals_asked"], robot["goals_reached"], robot["collisions"]) == (1, 1, 0)
        assert robot["distance_m"] > 5.0
        assert robot["final_errors_m"][0] < 0.3
        assert 0.0 < robot["plan_seconds"][0] < report["seconds"]
        assert robot["ready_seconds"] > 0.0
    assert children() <= before


@pytest.mark.parametrize("arguments", [("--cloud", "http://127.0.0.1:1"), ("--admin-password-file", "password")])
def test_cloud_and_password_file_must_be_given_together(arguments: tuple[str, ...]) -> None:
    with pytest.raises(InvalidParameter, match="must be given together"):
        demo.run(parse("--headless", *arguments))


def test_a_missing_password_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="password file"):
        demo.run(parse("--headless", "--cloud", "http://127.0.0.1:1", "--admin-password-file", str(tmp_path / "none")))
