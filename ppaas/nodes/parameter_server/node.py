"""The parameter server: what the nodes of a clone were made with, and whatever else a robot's people want to keep."""

from collections.abc import Mapping
from typing import Any, ClassVar

import msgspec

from ppaas.errors import InvalidInput, NotFound
from ppaas.messages import rosapi
from ppaas.messages.message import Message
from ppaas.nodes.base import Context, Node, Reply, Service
from ppaas.nodes.parameter_server.tree import ParameterTree, read_value


class ParameterServerNode(Node):
    """Answers rosapi's services of parameters, whose values are JSON.

    A node's parameters are called ``/node/name``. They can be read, and not set: a node reads them when it is made.
    Any other name is free.

    Parameters
    ----------
    context : Context
        Of its home.
    own : dict of dict
        The parameters of each node, and of what it plugs in, by name.
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

    def __init__(self, context: Context, own: Mapping[str, Mapping[str, Any]]) -> None:
        super().__init__(context)
        self._tree = ParameterTree(own)
        self._state: bytes | None = None

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Read or change a parameter.

        Raises
        ------
        NotFound
            There is none of that name, and no default was given.
        InvalidParameter
            It is no name, no value, or a node's own.
        QuotaExceeded
            There would be too many, or too much in them.
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
        raise InvalidInput(f"service {service!r} takes no {type(request).__name__}")

    def _get(self, request: rosapi.GetParamRequest) -> str:
        try:
            return msgspec.json.encode(self._tree.get(request.name)).decode()
        except NotFound:
            if not request.default:
                raise
            return msgspec.json.encode(read_value(request.default)).decode()

    def checkpoint(self) -> bytes | None:
        """Return the free parameters, if any was ever set."""
        return self._state

    def restore(self, state: bytes) -> None:
        """Take the free parameters again."""
        self._tree.restore(state)
        self._state = state
