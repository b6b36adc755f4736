"""``ppaas robot put --nav2``: robot files from parameter files of Nav2."""

import json
from pathlib import Path

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.storage.records import house, put_map

EXAMPLE = str(ROOT / "docs" / "examples" / "nav2_turtlebot4.yaml")
TREE = str(ROOT / "docs" / "examples" / "nav2_navigate.xml")


@pytest.fixture(autouse=True)
def _map(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())


def written(folder: Path, name: str, text: str) -> str:
    (folder / name).write_text(text)
    return str(folder / name)


async def test_a_file_of_nav2_is_a_robot_file(ppaas: CommandLine) -> None:
    put = await ppaas("robot", "put", "tb4", "--nav2", EXAMPLE, "--bt-xml", TREE, "--map", "house")
    assert put.status == 0, put.err
    assert put.rows[1][:2] == ["tb4", "house"]
    assert put.err.splitlines()[-1].startswith("nav2_turtlebot4.yaml: ")
    assert put.err.splitlines()[-1].endswith(" 0 refused")
    robot = json.loads((await ppaas("robot", "show", "tb4", "--json")).out)
    assert (robot["base_global_planner"], robot["base_local_planner"]) == ("navfn", "dwa")
    assert robot["parameters"]["move_base"]["planner_frequency"] == 2.0
    assert robot["parameters"]["dwa"]["max_vel_x"] == 0.26


async def test_the_robot_file_and_the_later_file_win(ppaas: CommandLine, tmp_path: Path) -> None:
    own = written(tmp_path, "tb4.json", '{"map": "house", "cores": 0.5, "parameters": {"dwa": {"max_vel_x": 0.2}}}')
    later = written(tmp_path, "later.yaml", "amcl:\n  ros__parameters: {min_particles: 300}\n")
    put = await ppaas("robot", "put", "tb4", own, "--nav2", EXAMPLE, "--nav2", later)
    assert put.status == 0, put.err
    assert "later.yaml sets parameters.amcl.min_particles, and wins" in put.err
    robot = json.loads((await ppaas("robot", "show", "tb4", "--json")).out)
    assert (robot["cores"], robot["parameters"]["dwa"]["max_vel_x"]) == (0.5, 0.2)
    assert robot["parameters"]["amcl"]["min_particles"] == 300


async def test_a_dry_run_prints_the_robot_file_and_sends_nothing(ppaas: CommandLine) -> None:
    dry = await ppaas("robot", "put", "tb4", "--nav2", EXAMPLE, "--map", "house", "--dry-run")
    assert dry.status == 0, dry.err
    assert json.loads(dry.out)["base_global_planner"] == "navfn"
    assert (await ppaas("robot", "list")).out.startswith("no robots")
    as_json = await ppaas("robot", "put", "tb4", "--nav2", EXAMPLE, "--map", "a", "--dry-run", "--json")
    report = json.loads(as_json.err)
    assert report["counts"]["taken"] == sum(entry["outcome"] == "taken" for entry in report["entries"])


async def test_the_map_of_a_robot_file_may_be_another(ppaas: CommandLine, tmp_path: Path) -> None:
    own = written(tmp_path, "tb4.json", '{"map": "elsewhere"}')
    assert (await ppaas("robot", "put", "tb4", own, "--map", "house")).rows[1][:2] == ["tb4", "house"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "name a robot file, or files to import"),
        (("--nav2", EXAMPLE), "by --map MAP"),
        (("--nav2", "/nowhere.yaml", "--map", "house"), "cannot read /nowhere.yaml"),
        (("--nav2", TREE, "--map", "house"), "parameter file"),
        (("--nav2", EXAMPLE, "--bt-xml", EXAMPLE, "--map", "house"), "the behaviour tree is no XML"),
    ],
)
async def test_what_cannot_be_read_is_refused(ppaas: CommandLine, words: tuple[str, ...], text: str) -> None:
    put = await ppaas("robot", "put", "tb4", *words)
    assert (put.status, text in put.err) == (1, True), put.err


@pytest.mark.parametrize(
    ("content", "text"),
    [("[]", "must be an object"), ("{", "not JSON"), ('{"speed": 1}', "speed")],
)
async def test_robot_files_are_checked_beside_others(
    ppaas: CommandLine, tmp_path: Path, content: str, text: str
) -> None:
    put = await ppaas(
        "robot", "put", "tb4", written(tmp_path, "tb4.json", content), "--nav2", EXAMPLE, "--map", "house"
    )
    assert (put.status, text in put.err) == (1, True), put.err
