"""rosapi services respond as their clients expect."""

import json

import pytest

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.messages import service_type
from ppaas.wire.rosapi import SERVICES, GraphView, NodeView, answer

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
    arguments = dict.fromkeys(fields, "nav_msgs/GetMap" if "service" in service else "nav_msgs/Path")
    response = json.loads(answer(service, json.dumps(arguments).encode(), GraphView(0.0)))
    assert list(response) == list(kind.response.__struct_encode_fields__)
