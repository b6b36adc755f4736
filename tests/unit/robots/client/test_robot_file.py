import json
import shutil
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.robot_model.describe import describe
from robots.client.robot_file import RobotFile, load_robot_file, parse_robot_file
from robots.client.urdf_files import read_urdf_file
from tests.support.world.urdf import box, box_stl, joint, link, part, urdf

WHOLE = {
    "map": "depot",
    "model": "turtlebot2",
    "initial_pose": [1.0, -2.5, 0.5],
    "cores": 0.5,
    "base_global_planner": "navfn/NavfnROS",
    "base_local_planner": "dwa",
    "parameters": {"move_base": {"controller_frequency": 10.0}},
    "description": "Carries pallets",
    "properties": {"serial": "D-1", "forks": [1.2, 1.4]},
    "labels": {"zone": "hall-2"},
}


def test_a_complete_file_is_read_and_written_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "robot.json"
    path.write_text(json.dumps(WHOLE))
    robot = load_robot_file(path)
    assert robot.pose == Pose2D(1.0, -2.5, 0.5)
    assert json.loads(robot.encode()) == WHOLE


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
def test_every_encoding_of_unicode_is_read(encoding: str) -> None:
    text = json.dumps(WHOLE | {"description": "für Paletten"}, ensure_ascii=False, indent=1).replace("\n", "\r\n")
    assert parse_robot_file(text.encode(encoding)).description == "für Paletten"
    with pytest.raises(InvalidInput, match="not JSON"):
        parse_robot_file("für".encode("latin-1"))


def test_every_key_but_the_map_has_a_default() -> None:
    assert parse_robot_file('{"map": "depot"}') == RobotFile(map="depot")


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"colour": "red"}, "colour"),
        ({"map": 5}, "map"),
        ({"map": ""}, "map"),
        ({"initial_pose": [1.0, 2.0]}, "initial_pose"),
        ({"initial_pose": [1.0, 2.0, None]}, "initial_pose"),
        ({"initial_pose": [1e308, 1e999, 0.0]}, r"out of range|initial_pose"),
        ({"cores": 0.0}, "cores"),
        ({"cores": -1}, "cores"),
        ({"parameters": []}, "parameters"),
    ],
)
def test_an_invalid_key_is_named_and_the_valid_ones_are_listed(change: dict[str, object], error: str) -> None:
    text = json.dumps(WHOLE | change).replace("Infinity", "1e999")
    with pytest.raises(InvalidInput, match=error) as caught:
        parse_robot_file(text)
    if isinstance(caught.value, InvalidParameter):
        assert "the keys are map, model, initial_pose, cores" in str(caught.value)


def test_a_file_without_a_map_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="map"):
        parse_robot_file("{}")


@pytest.mark.parametrize("text", [b"", b"{", b"\xff", b"[" * 100_000])
def test_invalid_json_is_refused(text: bytes) -> None:
    with pytest.raises(InvalidInput):
        parse_robot_file(text)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"nowhere\.json"):
        load_robot_file(tmp_path / "nowhere.json")


def test_radius_is_added_to_the_parameters() -> None:
    robot = RobotFile(map="house", parameters={"global_costmap": {"footprint": []}, "dwa": {}})
    assert robot.with_radius(None) is robot
    assert robot.with_radius(0.4).parameters == {"global_costmap": {"footprint": [], "robot_radius": 0.4}, "dwa": {}}
    with pytest.raises(InvalidParameter, match="must be an object"):
        RobotFile(map="house", parameters={"global_costmap": []}).with_radius(0.4)


@pytest.mark.parametrize(
    ("map_id", "tables", "unused"),
    [
        ("office", ["amcl"], None), ("office", ["grid_slam"], "grid_slam"), ("office", [], None),
        ("new:office", ["amcl", "grid_slam"], "amcl"), ("new:office", ["grid_slam"], None),
    ],
)  # fmt: skip
def test_parameters_of_the_other_localization_are_named(map_id: str, tables: list[str], unused: str | None) -> None:
    assert RobotFile(map=map_id, parameters={name: {"tf_prefix": "a"} for name in tables}).unused == unused


@pytest.mark.parametrize(
    ("given", "section"),
    [(True, {"traffic": {}}), ({"spacing": 0.6}, {"traffic": {"spacing": 0.6}}), (False, {})],
)
def test_a_robot_that_takes_part_in_traffic_has_parameters_for_it(given: object, section: dict[str, object]) -> None:
    robot = parse_robot_file(json.dumps(WHOLE | {"traffic": given}))
    others = {"move_base": {"controller_frequency": 10.0}}
    assert robot.parameters == others | section
    assert parse_robot_file(robot.encode()) == robot
    assert parse_robot_file(json.dumps(WHOLE)).parameters == others
    with pytest.raises(InvalidParameter, match="traffic"):
        parse_robot_file(json.dumps(WHOLE | {"traffic": 1}))


MESH = '<mesh filename="{}" scale="2 1 1"/>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A package ``r`` with ``urdf`` and ``meshes``."""
    (tmp_path / "r" / "meshes").mkdir(parents=True)
    (tmp_path / "r" / "urdf").mkdir()
    (tmp_path / "r" / "meshes" / "base.stl").write_bytes(box_stl((-0.3, -0.25, 0.0), (0.3, 0.25, 0.3)))
    return tmp_path


def read(path: Path, *inside: str, folders=()) -> bytes:
    path.write_bytes(urdf(*inside))
    return read_urdf_file(path, folders)


def is_known(data: bytes) -> bool:
    footprint = describe(data).footprint
    assert footprint in ((), ((-0.6, -0.25), (0.6, -0.25), (0.6, 0.25), (-0.6, 0.25)))
    return bool(footprint)


@pytest.mark.parametrize("name", ["package://r/meshes/base.stl", "../meshes/base.stl", "file://{0}/r/meshes/base.stl"])
def test_mesh_of_the_package_of_the_urdf_is_found(folder: Path, name: str):
    mesh = part(MESH.format(name.format(folder)))
    assert is_known(read(folder / "r" / "urdf" / "r.urdf", link("base_link", mesh)))


def test_mesh_of_a_url_with_spaces_is_found(folder: Path):
    shutil.copy(folder / "r" / "meshes" / "base.stl", folder / "my base.stl")
    mesh = part(MESH.format(f"file://{folder}/my%20base.stl"))
    assert is_known(read(folder / "r.urdf", link("base_link", mesh)))


def test_collisions_in_comments_do_not_keep_visuals_from_their_extents(folder: Path):
    path = folder / "r" / "urdf" / "r.urdf"
    visual = f"<visual><geometry>{MESH.format('package://r/meshes/base.stl')}</geometry></visual>"
    comment = '<!-- <collision><geometry><box size="1 1 1"/></geometry></collision> -->'
    assert is_known(read(path, f'<link name="base_link">{comment}{visual}</link>'))


def test_mesh_beside_the_urdf_is_found_whatever_its_package(folder: Path):
    shutil.copy(folder / "r" / "meshes" / "base.stl", folder)
    assert is_known(read(folder / "r.urdf", link("base_link", part(MESH.format("package://other/meshes/base.stl")))))


def test_mesh_in_a_folder_of_its_own_or_in_an_installed_package_is_found(folder: Path, monkeypatch):
    other = folder / "elsewhere" / "deep" / "deeper" / "deepest"
    other.mkdir(parents=True)
    inside = link("base_link", part(MESH.format("package://r/meshes/base.stl")))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    assert not is_known(read(other / "r.urdf", inside))
    for place in (folder, folder / "r", folder / "r" / "meshes"):
        assert is_known(read(other / "r.urdf", inside, folders=[place]))
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{folder}")
    assert is_known(read(other / "r.urdf", inside))
    (folder / "share").symlink_to(folder)
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(folder))
    assert is_known(read(other / "r.urdf", inside))


def test_urdf_is_unchanged_but_for_the_extents(folder: Path):
    path = folder / "r" / "r.urdf"
    mesh = part(MESH.format("package://r/meshes/base.stl"))
    known = part('<mesh filename="package://r/meshes/base.stl" bounding_box="0 0 0 1 1 1"/>')
    seen = part(MESH.format("package://r/meshes/base.stl"), kind="visual")
    inside = (link("base_link", mesh, known, seen), "<!-- a comment -->")
    written = read(path, *inside)
    box = ' bounding_box="-0.300000012 -0.25 0 0.300000012 0.25 0.300000012"'
    assert written == urdf(*inside).replace(b"<mesh filename", f"<mesh{box} filename".encode(), 1)
    visual = urdf(link("base_link", seen))
    path.write_bytes(visual)
    assert read_urdf_file(path).count(b"bounding_box") == 1  # without a collision, visuals count


def test_mesh_that_is_missing_or_of_another_format_leaves_the_urdf_to_the_cloud(folder: Path):
    inside = [link("base_link", part(box(1, 1, 1)), part(MESH.format("package://r/meshes/no.stl")))]
    inside += [link("a", part(MESH.format("package://r/meshes/base.fbx"))) + joint("a"), link("b", part("<mesh/>"))]
    assert read(folder / "r" / "r.urdf", *inside) == urdf(*inside)
    (folder / "r" / "x.urdf").write_bytes("<robot name='ä'/>".encode("latin-1"))
    assert read_urdf_file(folder / "r" / "x.urdf") == "<robot name='ä'/>".encode("latin-1")


def test_damaged_mesh_and_missing_urdf_are_refused_by_name(folder: Path):
    (folder / "r" / "meshes" / "base.stl").write_bytes(b"junk")
    with pytest.raises(InvalidInput, match=r"base\.stl.*cannot be read"):
        read(folder / "r" / "r.urdf", link("base_link", part(MESH.format("package://r/meshes/base.stl"))))
    with pytest.raises(InvalidInput, match="cannot read the URDF"):
        read_urdf_file(folder / "no.urdf")
