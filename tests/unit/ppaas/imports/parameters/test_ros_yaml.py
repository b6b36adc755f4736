"""Parameter files of ROS: nodes, namespaces, lines, repeated names, limits."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters import ros_yaml
from ppaas.imports.parameters.ros_yaml import GivenValue, read_parameter_file

NAV2 = b"""\
local_costmap:
  local_costmap:
    ros__parameters:
      plugins: ["voxel_layer", "inflation_layer"]
      voxel_layer:
        enabled: True
/**:
  ros__parameters:
    use_sim_time: $(var sim)
"""


def test_nodes_of_ros_2_have_namespaces_and_dotted_names() -> None:
    file = read_parameter_file(NAV2)
    assert file.is_ros2
    assert file.nodes == {
        "local_costmap/local_costmap": {
            "plugins": GivenValue(["voxel_layer", "inflation_layer"], 4),
            "voxel_layer.enabled": GivenValue(True, 6),
        },
        "**": {"use_sim_time": GivenValue("$(var sim)", 9)},
    }


def test_a_file_of_ros_1_has_nodes_or_loose_parameters() -> None:
    file = read_parameter_file(b"footprint: [[1, 2], [3, 4]]\nTebLocalPlannerROS:\n  max_vel_x: 0.4\n")
    assert not file.is_ros2
    assert file.nodes == {
        "": {"footprint": GivenValue([[1, 2], [3, 4]], 1)},
        "TebLocalPlannerROS": {"max_vel_x": GivenValue(0.4, 3)},
    }


def test_a_repeated_name_counts_once_and_is_listed() -> None:
    file = read_parameter_file(b"amcl:\n  ros__parameters:\n    z_hit: 0.5\n    z_hit: 0.6\n")
    assert file.nodes["amcl"]["z_hit"].value == 0.6
    assert file.repeated == [("amcl.ros__parameters.z_hit", 4)]


def test_merge_keys_are_applied() -> None:
    file = read_parameter_file(b"base: &base {rate: 5.0}\ndwa:\n  <<: *base\n  sim_time: 1.7\n")
    assert {name: value.value for name, value in file.nodes["dwa"].items()} == {"rate": 5.0, "sim_time": 1.7}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"a: [1", "line 2"),
        (b"- 1\n- 2\n", "must be a mapping"),
        (b"", "must be a mapping"),
        (b"a: !!python/name:os.system x\n", "could not determine a constructor"),
        (b"a:\n  <<: 3\n", "line 2: << must be a mapping"),
    ],
)  # fmt: skip
def test_other_files_are_refused(text: bytes, words: str) -> None:
    with pytest.raises(InvalidParameter, match=words):
        read_parameter_file(text)


def test_what_looks_like_a_date_or_a_number_and_is_none_is_text() -> None:
    digits = b"9" * 5000
    values = read_parameter_file(b"a: {date: 2026-13-45, number: " + digits + b", 2026-02-30: 1}").nodes["a"]
    assert {name: given.value for name, given in values.items()} == {
        "date": "2026-13-45", "number": digits.decode(), "2026-02-30": 1,
    }  # fmt: skip
    with pytest.raises(InvalidParameter, match="line 2: month must be"):
        read_parameter_file(b"a:\n  b: [1, 2026-13-45]")


def test_marks_that_a_merge_has_left_are_named() -> None:
    text = b"amcl:\n  max_beams: 30\n<<<<<<< HEAD\n  alpha1: 0.2\n=======\n  alpha1: 0.3\n>>>>>>> 9f0c1d2 (noise)\n"
    with pytest.raises(InvalidParameter, match="line 3 is a mark of git, which has not merged two versions"):
        read_parameter_file(text)


def test_deep_and_many_values_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    deep = "\n".join(" " * level + f"a{level}:" for level in range(ros_yaml.MAX_DEPTH + 5)).encode() + b" 1\n"
    with pytest.raises(InvalidParameter, match="deep"):
        read_parameter_file(deep)
    monkeypatch.setattr(ros_yaml, "MAX_VALUES", 10)
    with pytest.raises(InvalidParameter, match="more than 10 values"):
        read_parameter_file(b"a: [1, 2, 3, 4, 5, 6]\nb: [1, 2, 3, 4, 5, 6]\n")
    monkeypatch.setattr(ros_yaml, "MAX_FILE", 4)
    with pytest.raises(InvalidParameter, match="at most 4"):
        read_parameter_file(b"a: 12345\n")


def test_repeated_aliases_count_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ros_yaml, "MAX_VALUES", 100)
    text = b"a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a]\nc: [*b, *b, *b, *b]\n"
    with pytest.raises(InvalidParameter, match="more than 100 values"):
        read_parameter_file(text)


def test_merges_of_merges_cost_no_more_than_their_keys() -> None:
    levels = [b"a0: &a0 {rate: 1.0}"]
    levels += [f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 9)}], k{n}: {n}}}".encode() for n in range(1, 15)]
    file = read_parameter_file(b"\n".join(levels))
    assert len(file.nodes["a14"]) == 15
