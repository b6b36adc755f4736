"""Types of names in paths and bodies: they follow the rule of `storage.names`, which OpenAPI describes."""

import re
from collections.abc import Callable
from typing import Annotated, Literal

from fastapi import Path
from pydantic import AfterValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from engine.rights.globs import ADDRESS, is_address
from ppaas.maps.new_map import NEW, new_map_id
from storage.names import PATTERN, is_name
from storage.sharing_records import GROUP, is_grantee

MAX_SHOWN = 64


def _name(text: str) -> str:
    if not is_name(text):
        shown = text if len(text) <= MAX_SHOWN else text[:MAX_SHOWN] + "…"
        message = "{shown} is not a valid name: use 1 to 64 letters, digits, '_', '.' and '-', a letter or digit first"
        raise PydanticCustomError("name", message, {"shown": repr(shown)})
    return text


def _robot_map(text: str) -> str:
    new = new_map_id(text)
    if new is not None and not is_name(new):
        shown = new if len(new) <= MAX_SHOWN else new[:MAX_SHOWN] + "…"
        message = (
            "{shown} is not a valid name of a new map: after 'new:', give the id under which it is to be published, "
            "1 to 64 letters, digits, '_', '.' and '-', a letter or digit first"
        )
        raise PydanticCustomError("name", message, {"shown": repr(shown)})
    return _name(text) if new is None else text


def is_plugin_name(text: str) -> bool:
    """Return whether a text may be the name of a plug-in, or its ROS name: package/Class or package::Class."""
    return all(map(is_name, re.split("/|::", text, maxsplit=1)))


def _plugin(text: str) -> str:
    if not is_plugin_name(text):
        raise PydanticCustomError(
            "plugin", "a plug-in must be given by its name, such as navfn, or its ROS name, package/Class"
        )
    return text


def _address_of(kind: Literal["robot", "building"]) -> Callable[[str], str]:
    def check(text: str) -> str:
        if not is_address(text):
            shown = text if len(text) <= MAX_SHOWN else text[:MAX_SHOWN] + "…"
            message = (
                "{shown} is not a valid address of a {kind}: give its id, 1 to 64 letters, digits, '_', '.' and '-', "
                "a letter or digit first; for a {kind} of another user, OWNER:ID"
            )
            raise PydanticCustomError("address", message, {"shown": repr(shown), "kind": kind})
        return text

    return check


def _grantee(text: str) -> str:
    if not is_grantee(text):
        shown = text if len(text) <= MAX_SHOWN else text[:MAX_SHOWN] + "…"
        message = "{shown} is not a valid name: give the id of a user, or 'group:' and the name of a group"
        raise PydanticCustomError("grantee", message, {"shown": repr(shown)})
    return text


def _version(text: str) -> str:
    if not is_name(text):
        raise PydanticCustomError("version", "a version must be the SHA-256 of a map's files, 64 hex digits")
    return text


_SCHEMA = {"type": "string", "pattern": f"^{PATTERN}$", "minLength": 1, "maxLength": 64}
_ROBOT_MAP_SCHEMA = {"type": "string", "pattern": f"^({NEW})?{PATTERN}$", "minLength": 1, "maxLength": 64 + len(NEW)}
_ADDRESS_SCHEMA = {"type": "string", "pattern": f"^{ADDRESS}$", "minLength": 1, "maxLength": 129}
_GRANTEE_SCHEMA = {"type": "string", "pattern": f"^({GROUP})?{PATTERN}$", "minLength": 1, "maxLength": 64 + len(GROUP)}
_PLUGIN_SCHEMA = {"type": "string", "pattern": f"^{PATTERN}((/|::){PATTERN})?$", "minLength": 1, "maxLength": 130}

Name = Annotated[str, AfterValidator(_name), WithJsonSchema(_SCHEMA)]
RobotMap = Annotated[str, AfterValidator(_robot_map), WithJsonSchema(_ROBOT_MAP_SCHEMA)]
PluginName = Annotated[str, AfterValidator(_plugin), WithJsonSchema(_PLUGIN_SCHEMA)]
Version = Annotated[str, AfterValidator(_version), WithJsonSchema(_SCHEMA)]

MapId = Annotated[Name, Path(examples=["office"])]
VersionId = Annotated[Version, Path(description="SHA-256 of the map's files", examples=["0" * 64])]
RobotAddress = Annotated[
    Annotated[str, AfterValidator(_address_of("robot")), WithJsonSchema(_ADDRESS_SCHEMA)],
    Path(description="Id of the robot; `OWNER:ID` for one of another user", examples=["tb1"]),
]
BuildingAddress = Annotated[
    Annotated[str, AfterValidator(_address_of("building")), WithJsonSchema(_ADDRESS_SCHEMA)],
    Path(description="Id of the building; `OWNER:ID` for one of another user", examples=["hotel"]),
]
RobotId = Annotated[Name, Path(description="Id of one of the caller's robots", examples=["tb1"])]
Grantee = Annotated[
    Annotated[str, AfterValidator(_grantee), WithJsonSchema(_GRANTEE_SCHEMA)],
    Path(description="Id of a user, or `group:` and the name of a group", examples=["ann"]),
]
GroupId = Annotated[Name, Path(examples=["hall"])]
UserId = Annotated[Name, Path(description="`me` is the calling user", examples=["ann"])]
TokenId = Annotated[Name, Path(description="`current` is the token of this request", examples=["current"])]
PlanId = Annotated[Name, Path(examples=["9f1c0d6f6c1a4d0c8a52ad2d0cf0e6b1"])]
MachineId = Annotated[Name, Path(examples=["local"])]
EndpointId = Annotated[Name, Path(examples=["local-1"])]
ContainerId = Annotated[Name, Path(examples=["c1"])]
PlannerName = Annotated[Name, Path(description="Name of the planner, not its ROS name", examples=["dijkstra"])]
