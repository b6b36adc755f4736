"""Parameters of robots by the names that viewers use: ``/ROBOT/node/parameter``."""

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from endpoints.foxglove.robot_view import RobotView
from ppaas.errors import PPaaSError, QuotaExceeded
from ppaas.messages import decode, rosapi
from ppaas.wire.foxglove.requests import Parameter

MAX_VALUE = 256 << 10
"""Largest text that is sent as a parameter [bytes]."""

MAX_WATCHED = 1000
"""Largest number of parameters that one viewer watches by name."""

Values = Mapping[str, Parameter]
"""Parameters by name."""


async def read_parameters(view: RobotView) -> dict[str, Parameter]:
    """Return all parameters of a robot; raises the error of the call."""
    answer = await view.ask("rosapi/get_param", {"name": "/"})
    tree = msgspec.json.decode(decode(rosapi.GetParamResponse, answer).value)
    return {one.name: one for one in _leaves(f"/{view.name}", tree)}


def _leaves(name: str, value: Any) -> Iterator[Parameter]:
    """Yield the parameters in a tree; a list of other things than numbers is a value itself."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(f"{name}/{key}", inner)
    elif not (isinstance(value, str) and len(value) > MAX_VALUE):
        yield Parameter(name, value, _type_of(value))


def _type_of(value: Any) -> str | None:
    if isinstance(value, float):
        return "float64"
    if isinstance(value, list) and value and all(isinstance(one, float) for one in value):
        return "float64_array"
    return None


async def write_parameter(view: RobotView, name: str, parameter: Parameter) -> None:
    """Set a parameter of a robot, or remove it if it has no value; raises the error of the call.

    Parameters
    ----------
    view : RobotView
    name : str
        Name without the robot's name.
    parameter : Parameter
    """
    if parameter.value is msgspec.UNSET:
        await view.ask("rosapi/delete_param", {"name": f"/{name}"})
        return
    value = msgspec.json.encode(_as_float(parameter)).decode()
    await view.ask("rosapi/set_param", {"name": f"/{name}", "value": value})


def _as_float(parameter: Parameter) -> Any:
    """Return a value; a number of 64 bits that JSON writes without a point is a float again."""
    value = parameter.value
    if parameter.type == "float64" and isinstance(value, int):
        return float(value)
    if parameter.type == "float64_array" and isinstance(value, list):
        return [float(one) if isinstance(one, int) else one for one in value]
    return value


class WatchedParameters:
    """Parameters whose changes a viewer wants to be sent."""

    def __init__(self) -> None:
        self._names: set[str] = set()
        self._all = False
        self._sent: dict[str, Parameter] = {}

    def __bool__(self) -> bool:
        return self._all or bool(self._names)

    @property
    def names(self) -> frozenset[str]:
        """Names of the watched ones; empty for all."""
        return frozenset() if self._all else frozenset(self._names)

    def add(self, names: list[str]) -> None:
        """Watch parameters; without names, all.

        Raises
        ------
        QuotaExceeded
            They are too many.
        """
        if len(self._names | set(names)) > MAX_WATCHED:
            raise QuotaExceeded(f"at most {MAX_WATCHED} parameters can be watched by name: watch all, without names")
        self._names.update(names)
        self._all = self._all or not names

    def remove(self, names: list[str]) -> None:
        """Stop watching parameters; without names, all of them."""
        self._names.difference_update(names)
        if not names:
            self._names, self._all = set(), False
        self._sent = {name: one for name, one in self._sent.items() if self.includes(name)}

    def includes(self, name: str) -> bool:
        """Return whether a parameter is watched."""
        return self._all or name in self._names

    def changed(self, values: Values) -> list[Parameter]:
        """Return the watched ones that differ from those sent before; one that is gone has no value."""
        now = {name: one for name, one in values.items() if self.includes(name)}
        found = [one for name, one in now.items() if self._sent.get(name) != one]
        gone = [Parameter(name) for name in self._sent if name not in now]
        self._sent = now
        return found + gone


async def read_all(views: list[RobotView]) -> tuple[dict[str, Parameter], list[PPaaSError]]:
    """Return the parameters of some robots, and the errors of those whose parameters cannot be read."""
    found: dict[str, Parameter] = {}
    errors = []
    for view in views:
        try:
            found |= await read_parameters(view)
        except PPaaSError as error:
            errors.append(error)
    return found, errors
