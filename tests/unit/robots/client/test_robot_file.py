import json
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from robots.client.robot_file import RobotFile, load_robot_file, parse_robot_file

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
