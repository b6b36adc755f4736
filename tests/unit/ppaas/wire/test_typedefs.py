"""Message definitions match the structs, in ROS's terms."""

import pytest

from ppaas.messages import message_type, message_types, service_type
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import PoseWithCovariance
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.messages.registry import type_name
from ppaas.messages.rosapi import TypeDef
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.typedefs import full_text, typedefs

HEADER = TypeDef(
    "std_msgs/Header", ["seq", "stamp", "frame_id"], ["uint32", "time", "string"], [-1] * 3, ["0", "{}", ""]
)
TIME = TypeDef("time", ["secs", "nsecs"], ["int32", "int32"], [-1, -1], ["0", "0"])


def fields(definition: TypeDef) -> dict[str, tuple[str, int]]:
    types = zip(definition.fieldtypes, definition.fieldarraylen, strict=True)
    return dict(zip(definition.fieldnames, types, strict=True))


def test_typedefs_include_each_nested_message_once():
    assert typedefs(Header) == [HEADER, TIME]
    array, header, time, status, goal_id = typedefs(GoalStatusArray)
    assert fields(array) == {"header": ("std_msgs/Header", -1), "status_list": ("actionlib_msgs/GoalStatus", 0)}
    assert (header, time) == (HEADER, TIME)
    assert array.examples == ["{}", "[]"]
    assert fields(goal_id) == {"stamp": ("time", -1), "id": ("string", -1)}
    assert dict(zip(status.constnames, status.constvalues, strict=True))["SUCCEEDED"] == "3"


def test_numbers_and_arrays_have_ros_types():
    scan, grid = fields(typedefs(LaserScan)[0]), fields(typedefs(OccupancyGrid)[0])
    assert (scan["range_max"], scan["ranges"], grid["data"]) == (("float32", -1), ("float32", 0), ("int8", 0))
    assert fields(typedefs(PoseWithCovariance)[0])["covariance"] == ("float64", 36)


@pytest.mark.parametrize("name", message_types())
def test_every_message_has_a_complete_definition(name):
    own, *others = typedefs(message_type(name))
    known = {definition.type for definition in others}
    assert sorted(own.fieldnames) == sorted(message_type(name).__struct_encode_fields__)
    for definition in (own, *others):
        nested = {kind for kind in definition.fieldtypes if "/" in kind or kind in ("time", "duration")}
        assert nested <= known | {own.type}
    text = full_text(message_type(name))
    assert all(f" {field}\n" in text for field in own.fieldnames)
    assert text.count("MSG: ") == len([kind for kind in known if "/" in kind])


def test_full_text_is_that_of_ros():
    rule = "=" * 80
    assert full_text(PoseWithCovariance).startswith(
        f"geometry_msgs/Pose pose\nfloat64[36] covariance\n\n{rule}\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point"
    )
    assert "uint8 PENDING=0\n" in full_text(GoalStatusArray)
    assert full_text(Time) == "int32 secs\nint32 nsecs\n"


def test_service_request_types_have_ros_names():
    get_plan = service_type("nav_msgs/GetPlan")
    assert type_name(get_plan.request) == "nav_msgs/GetPlanRequest"
    assert fields(typedefs(get_plan.request)[0])["tolerance"] == ("float32", -1)
