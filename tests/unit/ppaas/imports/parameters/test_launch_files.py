"""Launch files of ROS 1: parameters of their nodes, arguments, conditions, and files that they load."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.launch_files import MAX_LAUNCH, read_parameters
from ppaas.imports.parameters.ros1.amcl import import_amcl
from ppaas.imports.parameters.ros1.importing import import_ros1
from ppaas.imports.parameters.slam.gmapping import import_gmapping
from ppaas.imports.report import ImportReport
from tests.support.imported_parameters import entry_of, outcomes, refused

MOVE_BASE = b"""<launch>
  <arg name="base" default="base_footprint"/>
  <arg name="sim" default="false"/>
  <node pkg="move_base" type="move_base" name="move_base">
    <param name="base_local_planner" value="dwa_local_planner/DWAPlannerROS"/>
    <param name="DWAPlannerROS/max_vel_x" value="0.4"/>
    <param name="controller_frequency" value="9.0" if="$(arg sim)"/>
    <param name="local_costmap/robot_base_frame" value="$(arg base)"/>
    <rosparam file="$(find robot)/config/costmap.yaml" command="load" ns="local_costmap"/>
    <rosparam>
      planner_frequency: 2.0
      GlobalPlanner: {allow_unknown: false}
    </rosparam>
    <rosparam ns="local_costmap">width: 5.0</rosparam>
    <rosparam param="footprint">[[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]]</rosparam>
    <remap from="cmd_vel" to="base/cmd_vel"/>
  </node>
  <include file="$(find robot)/launch/amcl.launch"><arg name="x" value="1"/></include>
</launch>
"""


def test_parameters_of_move_base_are_read_from_its_launch_file() -> None:
    into = import_ros1(MOVE_BASE, "move_base.launch")
    assert into[0]["base_local_planner"] == "dwa"
    found = into[0]["parameters"]
    assert (found["dwa"], found["move_base"]) == ({"max_vel_x": 0.4}, {"planner_frequency": 2.0})
    assert found["local_costmap"] == {"width": 5.0}
    assert len(found["global_costmap"]["footprint"]) == 4
    assert refused(into) == []
    assert outcomes(into)["rosparam $(find robot)/config/costmap.yaml"] == "no effect"
    assert entry_of(into, "planner_frequency").line == 11


def test_parameters_of_amcl_and_gmapping_are_read_from_launch_files() -> None:
    text = (
        b'<launch><arg name="d" value="0.1"/><include file="x"><arg name="d" value="0.7"/></include>'
        b'<node pkg="amcl" type="amcl" name="loc"><param name="odom_alpha1" value="$(arg d)"/>'
        b'<param name="odom_model_type" value="diff"/><param name="min_particles" value="$(arg n)"/></node>'
        b'<node pkg="gmapping" type="slam_gmapping" name="m"><param name="delta" value="$(arg d)"/></node></launch>'
    )
    into = import_amcl(text, "amcl.launch")
    assert into[0]["parameters"]["amcl"] == {"odom_alpha1": 0.1, "odom_model_type": "diff"}
    assert "filled in by a launch file" in refused(into)[0]
    assert import_gmapping(text, "gmapping.launch")[0]["parameters"]["grid_slam"] == {"delta": 0.1}


def test_arguments_do_not_grow_without_end() -> None:
    arguments = "".join(f'<arg name="a{n + 1}" value="$(arg a{n})$(arg a{n})"/>' for n in range(60))
    node = '<node type="n"><param name="p" value="$(arg a60)"/></node>'
    text = f'<launch><arg name="a0" value="x"/>{arguments}{node}</launch>'
    value = read_parameters(text.encode(), ImportReport("f")).nodes["n"]["p"].value
    assert isinstance(value, str) and len(value) < 1000


def test_values_have_the_types_of_roslaunch() -> None:
    text = (
        b'<launch><node type="a"><param name="i" value="3"/><param name="f" value="3" type="double"/>'
        b'<param name="s" value="3" type="str"/><param name="b" value="true"/><param name="t" value="map"/>'
        b'<param name="y" value="[1, 2]" type="yaml"/></node></launch>'
    )
    values = read_parameters(text, ImportReport("f")).nodes["a"]
    assert {name: given.value for name, given in values.items()} == {
        "i": 3, "f": 3.0, "s": "3", "b": True, "t": "map", "y": [1, 2],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"<launch><node>", "not XML"),
        (b'<!DOCTYPE l [<!ENTITY a "b">]><launch>&a;</launch>', "no document type"),
        (b"<a>" * 100, "nested more than"),
        (b"<" + b" " * MAX_LAUNCH, "at most"),
    ],
)
def test_a_file_that_cannot_be_read_is_an_error(text: bytes, words: str) -> None:
    with pytest.raises(InvalidParameter, match=words):
        read_parameters(text, ImportReport("f"))
