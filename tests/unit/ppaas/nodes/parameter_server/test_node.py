"""Node ``parameter_server``: it answers as rosapi does, and has no state until a parameter is set."""

import json
from dataclasses import dataclass

import pytest

from ppaas.errors import InvalidParameter, NotFound, PPaaSError
from ppaas.messages import decode
from ppaas.messages.base.message import Empty, Message
from ppaas.nodes.base import Checkpoint
from ppaas.nodes.graph import Graph
from ppaas.nodes.parameter_server.node import ParameterServerNode
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.parameters import Parameters
from ppaas.plugins import parameters_in_use

OWN = {"move_base": {"controller_frequency": 10.0}}


@pytest.fixture
def graph() -> Graph:
    return with_server()


def with_server() -> Graph:
    made = Graph()
    made.add(lambda context: ParameterServerNode(context, OWN))
    return made


def ask(graph: Graph, name_: str, /, **fields: str) -> Message:
    """Call a service as a client does, with JSON."""
    service, answers = f"rosapi/{name_}", []
    request = decode(graph.service(service).type.request, json.dumps(fields))
    graph.call(service, request, answers.append)
    [answer] = answers
    if isinstance(answer, PPaaSError):
        raise answer
    assert isinstance(answer, graph.service(service).type.response)
    return answer


def test_parameter_values_are_json(graph):
    assert ask(graph, "get_param", name="/move_base/controller_frequency").value == "10.0"
    assert ask(graph, "set_param", name="/mine", value='{"a": [1, 2.5]}').successful
    assert ask(graph, "get_param", name="/mine/a").value == "[1,2.5]"
    assert ask(graph, "get_param_names").names == ["/mine/a", "/move_base/controller_frequency"]
    assert ask(graph, "has_param", name="/mine").exists
    assert ask(graph, "search_param", name="mine/a").global_name == "/mine/a"
    assert ask(graph, "delete_param", name="/mine").successful
    assert not ask(graph, "has_param", name="/mine").exists


def test_missing_parameter_returns_the_default(graph):
    assert ask(graph, "get_param", name="/none", default="7").value == "7"
    assert ask(graph, "get_param", name="/move_base/controller_frequency", default="7").value == "10.0"
    with pytest.raises(NotFound, match="/none"):
        ask(graph, "get_param", name="/none")
    assert ask(graph, "get_param", name="/none", default="seven").value == '"seven"'


def test_setting_a_nodes_parameter_is_refused_with_advice(graph):
    with pytest.raises(InvalidParameter, match="robot's file"):
        ask(graph, "set_param", name="/move_base/controller_frequency", value="20.0")


def test_set_parameters_are_part_of_the_checkpoint(graph):
    assert graph.checkpoints() == [], "nothing to keep so far"
    ask(graph, "set_param", name="/mine", value="1")
    elsewhere = with_server()
    elsewhere.restore(graph.checkpoints())
    assert ask(elsewhere, "get_param", name="/mine").value == "1"
    assert elsewhere.checkpoints() == graph.checkpoints()
    ask(elsewhere, "delete_param", name="/mine")
    assert elsewhere.checkpoints() == [Checkpoint("parameter_server", b"{}")]


def test_a_request_of_another_type_is_refused(graph):
    answers = []
    graph.call("rosapi/get_param", Empty(), answers.append)
    assert isinstance(answers[0], PPaaSError)


class Some(Parameters, frozen=True):
    rate: float = 2.0


@dataclass(frozen=True, slots=True)
class More:
    radius: float = 0.2


class Keeper:
    def __init__(self, *, allow: bool = True, hidden: int = 1) -> None:
        self.allow = allow


class Holder:
    def __init__(self, **parameters: float) -> None:
        self.parameters = More(**parameters)


@pytest.mark.parametrize(
    ("of", "expected"),
    [
        (Some(3.0), {"rate": 3.0}),
        (More(), {"radius": 0.2}),
        (Keeper(allow=False), {"allow": False}),
        (Holder(radius=0.1), {"radius": 0.1}),
    ],
)
def test_parameters_in_use_include_defaults(of, expected):
    assert parameters_in_use(of) == expected


# -- robot_description -------------------------------------------------------------------------------------------------

URDF = '<robot name="tb1"><link name="base_link"/></robot>'
NAMES = ["/robot_description", "/robot_state_publisher/robot_description"]


@pytest.fixture
def described() -> Graph:
    made, own = Graph(), {**OWN, "robot_state_publisher": {"laser_frame": ""}}
    made.add(lambda context: ParameterServerNode(context, own, UrdfText.of(URDF.encode())))
    return made


@pytest.mark.parametrize(
    "name", ["robot_description", *NAMES, "/robot_state_publisher:robot_description", "robot_description/"]
)
def test_the_urdf_is_a_parameter_by_its_names_in_ros_1_and_ros_2(described, name):
    assert json.loads(ask(described, "get_param", name=name).value) == URDF
    assert json.loads(ask(described, "get_param", name=name, default="none").value) == URDF
    assert ask(described, "has_param", name=name).exists


def test_the_urdf_is_listed_and_found(described):
    assert set(NAMES) <= set(ask(described, "get_param_names").names)
    assert ask(described, "search_param", name="robot_description").global_name == "/robot_description"


@pytest.mark.parametrize("name", ["/", "robot_state_publisher"])
def test_objects_of_namespaces_do_not_contain_it_because_of_its_size(described, name):
    assert "<robot" not in ask(described, "get_param", name=name).value


def test_a_robot_without_a_urdf_has_no_such_parameter(graph):
    assert not ask(graph, "has_param", name="robot_description").exists
    with pytest.raises(NotFound, match="/robot_description"):
        ask(graph, "get_param", name="robot_description")


@pytest.mark.parametrize("which", ["graph", "described"])
def test_a_client_may_set_another_description_and_delete_it(request, which):
    graph = request.getfixturevalue(which)
    ask(graph, "set_param", name="robot_description", value='"<robot/>"')
    assert ask(graph, "get_param", name="robot_description").value == '"<robot/>"'
    assert ask(graph, "get_param_names").names.count("/robot_description") == 1
    ask(graph, "delete_param", name="robot_description")
    assert ask(graph, "has_param", name="robot_description").exists == (which == "described")


def test_the_parameter_of_the_node_is_read_only(described):
    with pytest.raises(InvalidParameter, match="robot_state_publisher/robot_description is read only"):
        ask(described, "set_param", name="robot_state_publisher/robot_description", value='"<robot/>"')
    with pytest.raises(InvalidParameter, match="is read only"):
        ask(described, "delete_param", name="robot_state_publisher/robot_description")
