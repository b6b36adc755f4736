"""rosapi services respond as their clients expect."""

import json

import pytest

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.messages import message_type, message_types, service_type
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.rosapi import TypeDef
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import PoseWithCovariance
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.messages.registry import type_name
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.names import NameScope
from ppaas.wire.rosapi import SERVICES, GraphView, NodeView, answer, parameter_names_in_ros2
from ppaas.wire.typedefs import full_text, typedefs

ACTION = {f"tour/{part}": "toy_msgs/TourActionGoal" for part in ("goal", "cancel", "status", "feedback", "result")}
VIEW = GraphView(
    now=12.5,
    topics={"scan": "sensor_msgs/LaserScan", "cmd_vel": "geometry_msgs/Twist", "mine": "my_msgs/Thing"} | ACTION,
    services={
        "static_map": "nav_msgs/GetMap",
        "move_base/make_plan": "nav_msgs/GetPlan",
        "other_map": "nav_msgs/GetMap",
    },
    nodes={
        "move_base": NodeView(["cmd_vel"], ["scan", "tour/goal"], ["move_base/make_plan"]),
        "map_server": NodeView(services=("static_map",)),
        "watcher": NodeView(subscribes={"scan"}, publishes={"cmd_vel"}),
    },
)


def ask(service: str, view: GraphView = VIEW, /, **arguments: str) -> dict[str, object]:
    response: dict[str, object] = json.loads(answer(f"rosapi/{service}", json.dumps(arguments).encode(), view))
    return response


@pytest.mark.parametrize(
    ("service", "arguments", "expected"),
    [
        ("topic_type", {"topic": "/scan"}, {"type": "sensor_msgs/LaserScan"}),
        ("topic_type", {"topic": "scan"}, {"type": "sensor_msgs/LaserScan"}),
        ("topic_type", {"topic": "/nothing"}, {"type": ""}),
        ("topics_for_type", {"type": "geometry_msgs/Twist"}, {"topics": ["/cmd_vel"]}),
        ("topics_for_type", {"type": "geometry_msgs/msg/Twist"}, {"topics": ["/cmd_vel"]}),
        ("topics_for_type", {"type": "my_msgs/Thing"}, {"topics": ["/mine"]}),
        ("topics_for_type", {"type": "nav_msgs/Path"}, {"topics": []}),
        ("publishers", {"topic": "/cmd_vel"}, {"publishers": ["/move_base", "/watcher"]}),
        ("subscribers", {"topic": "/scan"}, {"subscribers": ["/move_base", "/watcher"]}),
        ("subscribers", {"topic": "/nothing"}, {"subscribers": []}),
        ("services", {}, {"services": ["/move_base/make_plan", "/other_map", "/static_map"]}),
        ("services_for_type", {"type": "nav_msgs/srv/GetMap"}, {"services": ["/other_map", "/static_map"]}),
        ("service_type", {"service": "/static_map"}, {"type": "nav_msgs/GetMap"}),
        ("service_type", {"service": "/nothing"}, {"type": ""}),
        ("service_providers", {"service": "/static_map"}, {"providers": ["/map_server"]}),
        ("service_node", {"service": "/static_map"}, {"node": "/map_server"}),
        ("service_node", {"service": "/nothing"}, {"node": ""}),
        ("nodes", {}, {"nodes": ["/map_server", "/move_base", "/watcher"]}),
        (
            "node_details",
            {"node": "/move_base"},
            {"subscribing": ["/scan", "/tour/goal"], "publishing": ["/cmd_vel"], "services": ["/move_base/make_plan"]},
        ),
        ("node_details", {"node": "/nothing"}, {"subscribing": [], "publishing": [], "services": []}),
        ("action_servers", {}, {"action_servers": ["/tour"]}),
        ("get_time", {}, {"time": {"secs": 12, "nsecs": 500000000}}),
    ],
)
def test_topics_services_and_nodes_are_listed(service, arguments, expected):
    assert ask(service, **arguments) == expected


def test_topics_types_and_definitions_have_the_same_order():
    response = ask("topics_and_raw_types")
    assert response["topics"] == sorted(f"/{topic}" for topic in VIEW.topics)
    types = dict(zip(response["topics"], response["types"], strict=True))
    texts = dict(zip(response["topics"], response["typedefs_full_text"], strict=True))
    assert ask("topics") == {"topics": response["topics"], "types": response["types"]}
    assert (types["/scan"], types["/mine"]) == ("sensor_msgs/LaserScan", "my_msgs/Thing")
    assert texts["/cmd_vel"].startswith("geometry_msgs/Vector3 linear\n")
    assert texts["/mine"] == "# the definition of my_msgs/Thing is not known here"


def test_an_action_without_all_its_topics_is_not_listed():
    topics = {name: kind for name, kind in ACTION.items() if name != "tour/status"}
    assert ask("action_servers", GraphView(0.0, topics=topics)) == {"action_servers": []}


@pytest.mark.parametrize(
    ("service", "kind", "first"),
    [
        ("message_details", "geometry_msgs/msg/Twist", ["linear", "angular"]),
        ("service_request_details", "nav_msgs/GetPlan", ["start", "goal", "tolerance"]),
        ("service_response_details", "nav_msgs/srv/GetPlan", ["plan"]),
        ("service_request_details", "std_srvs/Empty", []),
    ],
)
def test_types_are_described_field_by_field(service, kind, first):
    assert ask(service, type=kind)["typedefs"][0]["fieldnames"] == first


@pytest.mark.parametrize("service", ["message_details", "service_request_details", "service_response_details"])
@pytest.mark.parametrize("kind", ["my_msgs/Thing", "thing", ""])
def test_unknown_type_error_lists_the_known_types(service, kind):
    with pytest.raises(UnknownType, match=r"known: .*(nav_msgs|std_srvs)"):
        ask(service, type=kind)


@pytest.mark.parametrize(
    "arguments", [b'{"topic": 1}', b'["scan", "more"]', b'"scan"', b'{"topic":null}', b'{"topic":"scan","more":1}']
)
def test_invalid_arguments_are_refused(arguments):
    with pytest.raises(MalformedMessage):
        answer("rosapi/topic_type", arguments, VIEW)


@pytest.mark.parametrize("arguments", [b'["/scan"]', b'{"topic":"/scan"}', b'{"topic":"scan"}'])
def test_arguments_are_an_object_or_a_list(arguments):
    assert json.loads(answer("rosapi/topic_type", arguments, VIEW)) == {"type": "sensor_msgs/LaserScan"}


@pytest.mark.parametrize("arguments", [b"{}", b"[]", b"null"])
def test_arguments_that_are_left_out_are_empty(arguments):
    assert json.loads(answer("rosapi/topic_type", arguments, VIEW)) == {"type": ""}


@pytest.mark.parametrize("service", SERVICES)
def test_every_service_has_a_known_type_and_answers_an_empty_graph(service):
    kind = service_type(SERVICES[service])
    fields = kind.request.__struct_encode_fields__
    name = {"service": "nav_msgs/GetMap", "action": "nav2_msgs/FollowWaypoints"}
    wanted = [kind for word, kind in name.items() if word in service] or ["nav_msgs/Path"]
    arguments = dict.fromkeys(fields, wanted[0])
    response = json.loads(answer(service, json.dumps(arguments).encode(), GraphView(0.0)))
    assert list(response) == list(kind.response.__struct_encode_fields__)


# -- ROS 2 -------------------------------------------------------------------------------------------------------------

ROS_2 = {
    "action_feedback_details", "action_goal_details", "action_result_details", "action_servers", "action_type",
    "get_ros_version", "get_time", "interfaces", "message_details", "node_details", "nodes", "publishers",
    "service_node", "service_providers", "service_request_details", "service_response_details", "service_type",
    "services", "services_for_type", "subscribers", "topic_type", "topics", "topics_and_raw_types", "topics_for_type",
}  # fmt: skip
"""Services of rosapi in ROS 2 (rosbridge_suite 2.4), without those of parameters, which a node serves."""


def in_ros2(service: str, view: GraphView = VIEW, /, **arguments: str) -> dict[str, object]:
    text = json.dumps(arguments).encode()
    response: dict[str, object] = json.loads(answer(f"rosapi/{service}", text, view, ros2=True))
    return response


def test_all_services_of_ros_2_are_served():
    assert {f"rosapi/{name}" for name in ROS_2} <= set(SERVICES)


@pytest.mark.parametrize("package", ["rosapi", "rosapi_msgs/srv", "rosapi_msgs", "rosapi/srv"])
def test_types_of_services_may_be_spelled_as_in_ros_1_or_ros_2(package):
    assert service_type(f"{package}/TopicType") is service_type("rosapi/TopicType")
    view = GraphView(0.0, services={"rosapi/topics": "rosapi/Topics"})
    assert ask("services_for_type", view, type=f"{package}/Topics") == {"services": ["/rosapi/topics"]}


@pytest.mark.parametrize(
    ("service", "arguments", "expected"),
    [
        ("topic_type", {"topic": "/scan"}, {"type": "sensor_msgs/msg/LaserScan"}),
        ("topic_type", {"topic": "/nothing"}, {"type": ""}),
        ("service_type", {"service": "/static_map"}, {"type": "nav_msgs/srv/GetMap"}),
        ("service_type", {"service": "/nothing"}, {"type": ""}),
        ("topics_for_type", {"type": "geometry_msgs/msg/Twist"}, {"topics": ["/cmd_vel"]}),
        ("nodes", {}, {"nodes": ["/map_server", "/move_base", "/watcher"]}),
        ("action_type", {"action": "/tour"}, {"type": "toy_msgs/action/Tour"}),
        ("action_type", {"action": "/dock"}, {"type": "nav2_msgs/action/DockRobot"}),
        ("action_type", {"action": "/nothing"}, {"type": ""}),
        ("action_servers", {}, {"action_servers": ["/dock", "/tour"]}),
        ("get_ros_version", {}, {"version": 2, "distro": "ppaas"}),
    ],
)
def test_clients_of_ros_2_get_the_types_of_ros_2(service, arguments, expected):
    view = GraphView(VIEW.now, VIEW.topics, VIEW.services, {"dock": "nav2_msgs/DockRobot"}, VIEW.nodes)
    assert in_ros2(service, view, **arguments) == expected


def test_types_of_rosapi_itself_are_spelled_as_in_ros_2():
    view = GraphView(0.0, services={"rosapi/topics": "rosapi/Topics"})
    assert in_ros2("service_type", view, service="/rosapi/topics") == {"type": "rosapi_msgs/srv/Topics"}
    assert ask("service_type", view, service="/rosapi/topics") == {"type": "rosapi/Topics"}


def test_lists_of_topics_have_the_types_of_ros_2():
    for service in ("topics", "topics_and_raw_types"):
        response = in_ros2(service)
        types = dict(zip(response["topics"], response["types"], strict=True))
        assert (types["/scan"], types["/mine"]) == ("sensor_msgs/msg/LaserScan", "my_msgs/msg/Thing")


def test_all_interfaces_are_listed_once_and_those_of_services_and_actions_are_no_messages():
    interfaces = ask("interfaces")["interfaces"]
    assert len(interfaces) == len(set(interfaces))
    assert {
        "geometry_msgs/msg/Twist", "std_srvs/srv/Empty", "std_msgs/msg/Empty", "rosapi_msgs/msg/TypeDef",
        "rosapi_msgs/srv/Topics", "nav2_msgs/action/NavigateToPose", "move_base_msgs/action/MoveBase",
    } <= set(interfaces)  # fmt: skip
    assert not [name for name in interfaces if name.endswith(("Request", "Response"))]


@pytest.mark.parametrize("kind", ["nav2_msgs/action/FollowWaypoints", "nav2_msgs/FollowWaypointsAction"])
def test_details_of_an_action_are_those_of_its_goals_results_and_feedback(kind):
    first = {part: ask(f"action_{part}_details", type=kind)["typedefs"][0] for part in ("goal", "result", "feedback")}
    assert {part: typedef["fieldnames"] for part, typedef in first.items()} == {
        "goal": ["number_of_loops", "goal_index", "poses"],
        "result": ["missed_waypoints", "error_code", "error_msg"],
        "feedback": ["current_waypoint"],
    }


def test_details_of_an_unknown_action_are_refused_with_the_known_ones():
    with pytest.raises(UnknownType, match=r"unknown action type 'a_msgs/action/B'; known: .*NavigateToPose"):
        ask("action_goal_details", type="a_msgs/action/B")


def test_names_in_requests_may_be_below_the_namespace_of_the_robot():
    view = GraphView(VIEW.now, VIEW.topics, VIEW.services, {}, VIEW.nodes, NameScope(["tb1"]))
    assert ask("topic_type", view, topic="/tb1/scan") == {"type": "sensor_msgs/LaserScan"}
    assert ask("service_node", view, service="tb1/static_map") == {"node": "/map_server"}
    assert ask("node_details", view, node="/tb1/map_server")["services"] == ["/static_map"]
    assert ask("action_type", view, action="/tb1/tour") == {"type": "toy_msgs/action/Tour"}
    assert ask("topic_type", view, topic="a b") == {"type": ""}


def test_parameters_of_ros_2_are_named_by_their_node():
    names = b'{"names":["/move_base/controller_frequency","/dwa/a/b","/free"]}'
    found = json.loads(parameter_names_in_ros2(names))
    assert found == {"names": ["/move_base:controller_frequency", "/dwa:a/b", "/free"]}


def test_all_listed_actions_have_details():
    for kind in [name for name in ask("interfaces")["interfaces"] if "/action/" in name]:
        for part in ("goal", "result", "feedback"):
            assert ask(f"action_{part}_details", type=kind)["typedefs"]


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
