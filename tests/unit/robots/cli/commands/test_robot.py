import asyncio
import json
from pathlib import Path

import pytest

from engine.master.places import robot_key
from ppaas.mapping.serialization.mapping_file import pack_mapping
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_cloud import container
from tests.support.storage.records import house, put_map
from tests.support.world.mappings import room_mapping
from tests.support.world.urdf import EXAMPLES, box_stl, example, link, part, urdf


@pytest.fixture
def file(tmp_path: Path, ppaas: CommandLine) -> Path:
    """Return the file of a robot on a map that ann has published."""
    put_map(ppaas.services.map_store, house())
    put_map(ppaas.services.map_store, house("bobs", owner="bob"))
    (tmp_path / "tb1.json").write_text('{"map": "house", "initial_pose": [0.5, -0.5, 1.5], "cores": 0.25}')
    return tmp_path / "tb1.json"


def written(file: Path, **fields: object) -> str:
    """Write a robot file with these fields; return its path."""
    file.write_text(json.dumps(fields))
    return str(file)


async def test_a_robot_is_put_listed_shown_and_deleted(ppaas: CommandLine, file: Path) -> None:
    put = await ppaas("robot", "put", "tb1", str(file))
    assert put.status == 0, put.err
    assert put.rows[1] == ["tb1", "house", "turtlebot2", "0.5,", "-0.5,", "1.5", "0.25", "dijkstra", "dwa", "-"]
    assert (await ppaas("robot", "show", "tb1")).out == put.out
    assert (await ppaas("robot", "list")).rows[1] == ["tb1", "offline", "-", "-"]
    wide = await ppaas("robot", "list", "--wide")
    assert wide.rows[1] == ["tb1", "offline", "-", "-", "house", "-", "-", "no", *put.rows[1][2:]]
    shown = json.loads((await ppaas("robot", "show", "tb1", "--json")).out)
    assert (shown["user"], shown["parameters"]) == ("ann", {})
    assert (await ppaas("robot", "delete", "tb1")).status == 0
    assert (await ppaas("robot", "list")).out == "no robots; register one: ppaas robot put ID FILE.json\n"


async def test_a_robot_that_makes_a_map_is_put_and_unused_parameters_are_named(ppaas: CommandLine, file: Path) -> None:
    parameters = {"amcl": {"max_particles": 900}, "grid_slam": {"resolution": 0.1}}
    put = await ppaas("robot", "put", "tb1", written(file, map="new:office-2", parameters=parameters))
    assert (put.status, put.err) == (0, "note: the parameters of amcl are not used while the robot makes a map\n")
    assert put.rows[1][:2] == ["tb1", "new:office-2"]
    assert "new:office-2" in (await ppaas("robot", "list", "--wide")).rows[1]
    put = await ppaas("robot", "put", "tb1", written(file, map="house", parameters=parameters))
    assert put.err == "note: the parameters of grid_slam are not used on a published map\n"
    wrong = await ppaas("robot", "put", "tb1", written(file, map="new:two words"))
    assert "'two words' is not a valid name of a new map: after 'new:', give the id" in wrong.err


async def test_the_map_of_a_robot_is_shown_saved_and_published(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    await ppaas("robot", "put", "tb1", written(file, map="new:office-2"))
    ppaas.cloud.map_file = b"".join(pack_mapping(room_mapping(4)))
    saved = tmp_path / "tb1.posegraph"
    shown = await ppaas("robot", "map", "tb1", "--posegraph", str(saved))
    assert shown.rows == [["key_frames", "edges", "closures", "joined_with", "refused"], ["3", "2", "0", "-", "-"]]
    assert saved.read_bytes() == ppaas.cloud.map_file
    published = await ppaas("robot", "map", "tb1", "--publish", "office-2", "--message", "first walk", "--no-refine")
    assert published.err == ""
    assert (published.status, published.rows[1][0]) == (0, "office-2")
    assert ppaas.services.map_store.map_head("office-2").present.message == "first walk"
    assert "belongs to another user" in (await ppaas("robot", "map", "tb1", "--publish", "bobs")).err


async def test_a_urdf_is_put_shown_and_deleted(ppaas: CommandLine, file: Path) -> None:
    burger, waffle = (str(EXAMPLES / f"turtlebot3_{name}.urdf") for name in ("burger", "waffle"))
    put = await ppaas("robot", "put", "tb1", str(file), "--urdf", burger)
    assert put.rows[3][:4] == ["base_footprint", "0.124", "0.038", "0.19775"]
    assert put.rows[3][-2:] == ["base_scan", "(laser)"]
    assert (await ppaas("robot", "show", "tb1")).out == put.out
    summary = await ppaas("robot", "urdf", "put", "tb1", waffle)
    assert summary.rows[1][1] == "0.238"
    shown = json.loads((await ppaas("robot", "show", "tb1", "--json")).out)
    assert shown["urdf"] == json.loads((await ppaas("robot", "urdf", "put", "tb1", waffle, "--json")).out)
    assert ppaas.services.store.urdf("ann", "tb1") == example("turtlebot3_waffle")
    assert (await ppaas("robot", "urdf", "delete", "tb1")).status == 0
    assert (await ppaas("robot", "urdf", "get", "tb1")).err == "ppaas: not-found: unknown URDF of robot 'tb1'\n"


async def test_a_urdf_is_returned_unchanged(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file), "--urdf", str(EXAMPLES / "turtlebot2.urdf"))
    assert (await ppaas("robot", "urdf", "get", "tb1")).out.encode() == example("turtlebot2")


async def test_unknown_properties_of_a_urdf_are_reported(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    (tmp_path / "mesh.urdf").write_bytes(urdf(link("base_link", part('<mesh filename="a.stl"/>'))))
    summary = await ppaas("robot", "put", "tb1", str(file), "--urdf", str(tmp_path / "mesh.urdf"))
    assert summary.rows[3] == ["base_link", "-", "-", "-", "-", "-", "-"]
    assert summary.out.splitlines()[4].startswith("warning: link 'base_link': the extent of mesh 'a.stl' is unknown")


async def test_meshes_of_a_urdf_are_measured_where_they_are(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    mesh = urdf(link("base_link", part('<mesh filename="package://r/base.stl"/>')))
    for folder in ("robot", "elsewhere"):
        (tmp_path / folder).mkdir()
    (tmp_path / "robot" / "r.urdf").write_bytes(mesh)
    (tmp_path / "elsewhere" / "base.stl").write_bytes(box_stl((-0.3, -0.25, 0.0), (0.3, 0.25, 0.3)))
    put = ("robot", "put", "tb1", str(file), "--urdf", str(tmp_path / "robot" / "r.urdf"))
    assert (await ppaas(*put)).rows[3][:3] == ["base_link", "-", "-"]
    there = ("--mesh-folder", str(tmp_path / "elsewhere"))
    assert (await ppaas(*put, *there)).rows[3][:3] == ["base_link", "0.391", "0.25"]
    shown = await ppaas("robot", "urdf", "put", "tb1", str(tmp_path / "robot" / "r.urdf"), *there)
    assert shown.rows[1][:3] == ["base_link", "0.391", "0.25"]


async def test_radius_beside_a_urdf_is_that_of_the_robot_file(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    (tmp_path / "mesh.urdf").write_bytes(urdf(link("base_link", part('<mesh filename="a.stl"/>'))))
    put = await ppaas("robot", "put", "tb1", str(file), "--urdf", str(tmp_path / "mesh.urdf"), "--radius", "0.4")
    assert put.status == 0, put.err
    shown = json.loads((await ppaas("robot", "show", "tb1", "--json")).out)
    assert shown["parameters"] == {"global_costmap": {"robot_radius": 0.4}}


async def test_an_invalid_urdf_is_refused(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    assert "invalid-urdf: the URDF is not XML" in (await ppaas("robot", "urdf", "put", "tb1", str(file))).err
    missing = await ppaas("robot", "put", "tb2", str(file), "--urdf", "nowhere.urdf")
    assert missing.err.startswith("ppaas: invalid-input: cannot read the URDF: ")
    assert "unknown robot 'tb2'" in (await ppaas("robot", "show", "tb2")).err


async def test_robots_of_other_users_are_unknown(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    assert (await ppaas("robot", "show", "tb1", user="bob")).err == "ppaas: not-found: unknown robot 'tb1'\n"
    assert (await ppaas("robot", "list", "--json", user="bob")).out == "[]\n"


async def test_a_robot_needs_a_map_that_its_user_may_read(ppaas: CommandLine, file: Path) -> None:
    assert (await ppaas("robot", "put", "tb1", str(file), user="bob")).err == "ppaas: not-found: unknown map 'house'\n"


async def test_a_connected_robot_cannot_be_deleted(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    ppaas.cloud.running = [container()]
    ppaas.cloud.presence.came(robot_key("ann", "tb1"))
    ended = await ppaas("robot", "delete", "tb1")
    assert ended.status == 1
    assert ended.err.startswith("ppaas: conflict: robot 'tb1' is connected")


@pytest.mark.parametrize(
    ("content", "error"),
    [
        (None, "invalid-input: cannot read the robot file: "),
        ("{", "invalid-input: the robot file is not JSON: "),
        ("{}", "invalid-parameter: invalid robot file: "),
        ('{"map": "house", "colour": "red"}', "invalid-parameter: invalid robot file: "),
        ('{"map": "house", "cores": 0}', "invalid-parameter: invalid robot file: "),
        ('{"map": "house", "cores": 4096}', "invalid-input: body.cores: "),
    ],
)
@pytest.mark.usefixtures("file")
async def test_an_invalid_robot_file_is_refused(
    ppaas: CommandLine, tmp_path: Path, content: str | None, error: str
) -> None:
    wrong = str(tmp_path / "wrong.json")
    if content is not None:
        await asyncio.to_thread((tmp_path / "wrong.json").write_text, content)
    ended = await ppaas("robot", "put", "tb1", wrong)
    assert (ended.status, ended.out) == (1, "")
    assert ended.err.startswith(f"ppaas: {error}")


async def test_a_robot_is_changed_by_names_and_values(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    changes = ["cores=2", "initial_pose=[1, 2, 0]", "model=turtlebot3_burger", "parameters.amcl.max_particles=800"]
    changed = await ppaas("robot", "change", "tb1", *changes, "--json")
    assert changed.status == 0, changed.err
    robot = json.loads(changed.out)
    assert (robot["cores"], robot["initial_pose"], robot["model"]) == (2.0, [1.0, 2.0, 0.0], "turtlebot3_burger")
    assert robot["parameters"] == {"amcl": {"max_particles": 800}}
    back = await ppaas("robot", "change", "tb1", "cores=null", "parameters.amcl=null")
    assert back.rows[1][6] == "1"


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (["cores"], "invalid-input: 'cores' is not a valid change; write NAME=VALUE"),
        (["=1"], "invalid-input: '=1' is not a valid change; write NAME=VALUE"),
        (["a..b=1"], "invalid-input: 'a..b=1' is not a valid change; write"),
        (["cores=1", "cores=2"], "invalid-input: 'cores=2' is not a valid change; write"),
        (["parameters=1", "parameters.amcl=2"], "invalid-input: 'parameters.amcl=2' is not a valid change; write"),
        (["colour=red"], "invalid-input: body.colour: "),
        (["cores=-1"], "invalid-input: body.cores: "),
        (["cores=NaN"], "invalid-input: numbers must be finite"),
        (['parameters.amcl={"a": [1e999]}'], "invalid-input: numbers must be finite"),
        (["map=atlantis"], "not-found: unknown map 'atlantis'"),
        (["model=\udcff"], "invalid-input: '\\udcff' is not valid Unicode text"),
    ],
)
async def test_an_invalid_change_is_reported_in_one_line(
    ppaas: CommandLine, file: Path, change: list[str], error: str
) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    before = (await ppaas("robot", "show", "tb1", "--json")).out
    ended = await ppaas("robot", "change", "tb1", *change)
    assert (ended.status, ended.out) == (1, "")
    assert ended.err.startswith(f"ppaas: {error}") and ended.err.count("\n") == 1
    assert (await ppaas("robot", "show", "tb1", "--json")).out == before


@pytest.mark.parametrize("name", ["../x", "a b", "ä", "\udcff", "x" * 300, "%00", "a\x1b[31mb", "\u202etb1"])
async def test_an_invalid_robot_id_is_refused_in_one_line(ppaas: CommandLine, name: str) -> None:
    for verb in ("show", "delete"):
        ended = await ppaas("robot", verb, name)
        assert (ended.status, ended.out) == (1, "")
        assert ended.err.startswith("ppaas: ") and ended.err.count("\n") == 1
        assert "\x1b" not in ended.err


async def test_nodes_are_shown_with_homes_and_reasons_and_moved(ppaas: CommandLine, file: Path) -> None:
    await ppaas("robot", "put", "tb1", str(file))
    shown = await ppaas("robot", "nodes", "tb1")
    assert shown.rows[2] == ["move_base", "robot", "robot", "-0.5", "it", "is", "near"]
    [amcl, _] = json.loads((await ppaas("robot", "nodes", "tb1", "--json")).out)
    assert (amcl["node"], amcl["home"]) == ("amcl", "cloud")
    asked = await ppaas("robot", "nodes", "tb1", "--run", "amcl", "--home", "robot")
    assert asked.rows[1][:3] == ["amcl", "cloud", "robot"]
    assert (await ppaas("robot", "nodes", "tb1", "--run", "amcl")).rows[1][:3] == ["amcl", "cloud", "cloud"]
    assert "unknown robot" in (await ppaas("robot", "nodes", "tb2")).err
