"""``ppaas robot put`` with parameter files of other programs."""

import json
from pathlib import Path

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.storage.records import house, put_map

NAV2 = str(ROOT / "docs" / "examples" / "nav2_turtlebot4.yaml")
TREE = str(ROOT / "docs" / "examples" / "nav2_navigate.xml")


@pytest.fixture
def folder(tmp_path: Path, ppaas: CommandLine) -> Path:
    """Return a folder with files of a robot; ann has published the map ``house``."""
    put_map(ppaas.services.map_store, house())
    slam = "slam_toolbox:\n  ros__parameters:\n    resolution: 0.1\n    solver_plugin: x\n    resolutoin: 0.2\n"
    (tmp_path / "slam.yaml").write_text(slam)
    (tmp_path / "local.yaml").write_text("local_costmap: {width: 5.0}\nDWAPlannerROS: {max_vel_x: 0.4}\n")
    (tmp_path / "base.yaml").write_text("base_local_planner: dwa_local_planner/DWAPlannerROS\nplanner_frequency: 2.0\n")
    (tmp_path / "amcl.yaml").write_text("amcl: {odom_alpha1: 0.3, max_particles: 900}\n")
    (tmp_path / "later.yaml").write_text("amcl:\n  ros__parameters: {min_particles: 300}\n")
    (tmp_path / "tb1.json").write_text('{"map": "house", "parameters": {"amcl": {"max_particles": 700}}}')
    return tmp_path


async def test_a_robot_that_makes_a_map_is_put_by_a_file_of_slam_toolbox(ppaas: CommandLine, folder: Path) -> None:
    put = await ppaas("robot", "put", "tb1", "--slam-toolbox", str(folder / "slam.yaml"))
    assert put.status == 0, put.err
    assert "slam.yaml: 1 taken, 0 translated, 1 no effect, 1 refused" in put.err
    assert "5: slam_toolbox.resolutoin refused unknown parameter; did you mean 'resolution'?" in " ".join(
        put.err.split()
    )
    shown = json.loads((await ppaas("robot", "show", "tb1", "--json")).out)
    assert (shown["map"], shown["parameters"]["grid_slam"]["resolution"]) == ("new:tb1", 0.1)


async def test_a_file_of_nav2_is_a_robot_file_with_the_behaviour_tree_of_the_robot(
    ppaas: CommandLine, folder: Path
) -> None:
    later = str(folder / "later.yaml")
    put = await ppaas("robot", "put", "tb4", "--nav2", NAV2, "--nav2", later, "--bt-xml", TREE, "--map", "house")
    assert put.status == 0, put.err
    assert put.rows[1][:2] == ["tb4", "house"]
    assert "nav2_turtlebot4.yaml: " in put.err and put.err.splitlines()[-1].endswith(" 0 refused")
    assert "later.yaml sets parameters.amcl.min_particles, and wins" in put.err
    robot = json.loads((await ppaas("robot", "show", "tb4", "--json")).out)
    assert (robot["base_global_planner"], robot["base_local_planner"]) == ("navfn", "dwa")
    assert robot["parameters"]["move_base"]["planner_frequency"] == 2.0
    assert robot["parameters"]["amcl"]["min_particles"] == 300


async def test_the_map_of_a_robot_file_may_be_another(ppaas: CommandLine, folder: Path) -> None:
    (folder / "tb1.json").write_text('{"map": "elsewhere"}')
    put = await ppaas("robot", "put", "tb4", str(folder / "tb1.json"), "--map", "house")
    assert put.rows[1][:2] == ["tb4", "house"]


async def test_the_robot_file_wins_over_imports_and_may_come_after_them(ppaas: CommandLine, folder: Path) -> None:
    files = [str(folder / name) for name in ("local.yaml", "base.yaml")]
    amcl = str(folder / "amcl.yaml")
    put = await ppaas("robot", "put", "tb1", "--ros1", *files, "--amcl", amcl, str(folder / "tb1.json"))
    assert put.status == 0, put.err
    assert "the robot file sets parameters.amcl.max_particles, and wins" in put.err
    shown = json.loads((await ppaas("robot", "show", "tb1", "--json")).out)
    assert shown["parameters"] == {
        "amcl": {"odom_alpha1": 0.3, "max_particles": 700},
        "dwa": {"max_vel_x": 0.4},
        "local_costmap": {"width": 5.0},
        "move_base": {"planner_frequency": 2.0},
    }


async def test_a_dry_run_prints_the_file_and_sends_nothing(ppaas: CommandLine, folder: Path) -> None:
    options = ("--amcl", str(folder / "amcl.yaml"), "--map", "house", "--dry-run")
    dry = await ppaas("robot", "put", "tb1", *options, "--url", "http://127.0.0.1:9", user=None)
    assert dry.status == 0, dry.err
    assert json.loads(dry.out)["parameters"] == {"amcl": {"odom_alpha1": 0.3, "max_particles": 900}}
    machine = await ppaas("robot", "put", "tb1", *options, "--json")
    assert json.loads(machine.err)["counts"] == {"taken": 2, "translated": 0, "no effect": 0, "refused": 0}
    assert (await ppaas("robot", "list")).out.startswith("no robots")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--amcl", "amcl.yaml"), "name the published map of the robot by --map MAP"),
        ((), "name a robot file, or files to import"),
        (("--amcl", "none.yaml"), "cannot read"),
        (("--ros1", "slam.yaml"), "slam.yaml has ros__parameters"),
        (("tb1.json", "--cartographer", "amcl.yaml"), "the file is not in Lua"),
        (("--nav2", TREE), "parameter file"),
        (("--nav2", NAV2, "--bt-xml", NAV2), "the behaviour tree is no XML"),
        (("--map", "house", "--bt-xml", TREE), "--bt-xml and --namespace go with --nav2"),
        (("--map", "house", "--namespace", "tb1"), "--bt-xml and --namespace go with --nav2"),
    ],
)
async def test_what_cannot_be_imported_is_refused(
    ppaas: CommandLine, folder: Path, options: tuple[str, ...], words: str
) -> None:
    words_of = [str(folder / each) if "." in each else each for each in options]
    refused = await ppaas("robot", "put", "tb1", *words_of)
    assert refused.status == 1
    assert words in refused.err


@pytest.mark.parametrize(
    ("content", "words"), [("[]", "must be an object"), ("{", "the robot file is not JSON"), ('{"speed": 1}', "speed")]
)
async def test_robot_files_are_checked_beside_others(
    ppaas: CommandLine, folder: Path, content: str, words: str
) -> None:
    (folder / "tb1.json").write_text(content)
    files = (str(folder / "tb1.json"), "--amcl", str(folder / "amcl.yaml"))
    refused = await ppaas("robot", "put", "tb1", *files, "--map", "house")
    assert (refused.status, words in refused.err) == (1, True), refused.err


async def test_a_xacro_file_is_expanded(ppaas: CommandLine, folder: Path) -> None:
    xacro = folder / "cart.urdf.xacro"
    xacro.write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart"><xacro:arg name="size" default="0.2"/>'
        '<link name="base_link"><collision><geometry><cylinder radius="$(arg size)" length="0.1"/>'
        "</geometry></collision></link></robot>"
    )
    put = await ppaas("robot", "put", "tb1", str(folder / "tb1.json"), "--urdf", str(xacro), "--xacro-arg", "size=0.3")
    assert put.status == 0, put.err
    assert "0.3" in put.rows[3]
