"""Node ``parameter_server``: parameters of a clone's nodes, and free parameters of the robot's clients."""

from collections.abc import Mapping
from typing import Any, ClassVar

import msgspec

from ppaas.errors import InvalidInput, InvalidParameter, NotFound
from ppaas.messages import rosapi
from ppaas.messages.base.message import Message
from ppaas.nodes.base import Context, Node, Reply, Service
from ppaas.nodes.parameter_server.tree import ParameterTree, read_value
from ppaas.nodes.tf.urdf_text import UrdfText

DESCRIPTIONS = (("robot_description",), ("robot_state_publisher", "robot_description"))
"""Parts of the names of the URDF in ROS 1 and in ROS 2."""


class ParameterServerNode(Node):
    """Answers rosapi's parameter services; values are JSON.

    Parameters of nodes are named ``/node/name``. They are read-only, since a node reads them when it is created.
    Clients may set parameters of any other name.

    Parameters
    ----------
    context : Context
        The node's context.
    own : dict of dict
        Parameters of each node and plug-in, by its name.
    urdf : UrdfText, optional
        URDF of the robot: the parameter ``robot_description``, which in ROS 2 belongs to the state publisher.
    """

    name: ClassVar[str] = "parameter_server"
    services: ClassVar[tuple[Service, ...]] = (
        Service("rosapi/get_param", rosapi.GetParam),
        Service("rosapi/set_param", rosapi.SetParam),
        Service("rosapi/has_param", rosapi.HasParam),
        Service("rosapi/delete_param", rosapi.DeleteParam),
        Service("rosapi/search_param", rosapi.SearchParam),
        Service("rosapi/get_param_names", rosapi.GetParamNames),
    )

    def __init__(self, context: Context, own: Mapping[str, Mapping[str, Any]], urdf: UrdfText | None = None) -> None:
        super().__init__(context)
        self._tree = ParameterTree(own, {} if urdf is None else dict.fromkeys(DESCRIPTIONS, urdf.text))
        self._state: bytes | None = None

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Read or change parameters.

        Raises
        ------
        NotFound
            There is no parameter of that name, and no default was given.
        InvalidParameter
            The name or value is invalid, or the parameter is a node's.
        QuotaExceeded
            There would be too many free parameters, or too many bytes of them.
        """
        reply(self._answer(service, request))

    def _answer(self, service: str, request: Message) -> Message:
        match service, request:
            case "rosapi/get_param", rosapi.GetParamRequest():
                return rosapi.GetParamResponse(self._get(request))
            case "rosapi/set_param", rosapi.SetParamRequest():
                self._tree.set(request.name, read_value(request.value))
                self._state = self._tree.free()
                return rosapi.ParamChangedResponse()
            case "rosapi/delete_param", rosapi.ParamRequest():
                self._tree.delete(request.name)
                self._state = self._tree.free()
                return rosapi.ParamChangedResponse()
            case "rosapi/has_param", rosapi.ParamRequest():
                return rosapi.HasParamResponse(self._tree.has(request.name))
            case "rosapi/search_param", rosapi.ParamRequest():
                return rosapi.SearchParamResponse(self._tree.search(request.name))
            case "rosapi/get_param_names", _:
                return rosapi.GetParamNamesResponse(self._tree.names())
        raise InvalidInput(f"service {service!r} does not accept {type(request).__name__}")

    def _get(self, request: rosapi.GetParamRequest) -> str:
        try:
            return msgspec.json.encode(self._tree.get(request.name)).decode()
        except NotFound:
            if not request.default:
                raise
            return msgspec.json.encode(_default(request.default)).decode()

    def checkpoint(self) -> bytes | None:
        """Return the free parameters, or None if none was ever set."""
        return self._state

    def restore(self, state: bytes) -> None:
        """Set the free parameters of a checkpoint."""
        self._tree.restore(state)
        self._state = state


def _default(text: str) -> Any:
    """Return the default that a client gives a parameter: JSON, or as in rosbridge_suite any other text itself."""
    try:
        return read_value(text)
    except InvalidParameter:
        return text
