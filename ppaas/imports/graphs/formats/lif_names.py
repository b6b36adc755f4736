"""Names of LIF 2.0, which the drafts of 2026 have, as those before it.

Version 2.0 has *mobile robots* in the place of vehicles, longer names of limits, the types of a property as a list, and
layouts in origins: all layouts of one origin have the same coordinates.
"""

from collections.abc import Mapping
from typing import Any

from ppaas.imports.report import ImportReport

NAMES: Mapping[str, str] = {
    "mobileRobotTypeNodeProperties": "vehicleTypeNodeProperties",
    "mobileRobotTypeEdgeProperties": "vehicleTypeEdgeProperties",
    "mobileRobotTypeId": "vehicleTypeId",
    "mobileRobotOrientations": "vehicleOrientations",
    "mobileRobotOrientation": "vehicleOrientation",
    "maximumSpeed": "maxSpeed",
    "maximumRotationSpeed": "maxRotationSpeed",
    "minimumLoadHandlingDeviceHeight": "minHeight",
    "maximumMobileRobotHeight": "maxHeight",
    "lifId": "projectIdentification",
    "feasibleActions": "actions",
    **{f"{each}Descriptor": f"{each}Description" for each in ("layout", "node", "edge", "station", "action")},
    **{f"{each}descriptor": f"{each}Description" for each in ("layout", "node", "edge", "station", "action")},
}
"""Names of 2.0, and what they were before."""

TYPES, TYPE = "mobileRobotTypes", "vehicleTypeId"

DEEPEST = 20
"""Largest number of objects and lists that are in each other."""


def as_before(tree: Mapping[str, Any], report: ImportReport) -> Mapping[str, Any]:
    """Return a decoded file with the names of version 1; as it is if it has no names of version 2."""
    if not _is_of_2(tree):
        return tree
    origins = [each for each in _list(tree.get("origins")) if isinstance(each, dict)]
    given = [layout for origin in origins for layout in _list(origin.get("layouts"))] or _list(tree.get("layouts"))
    layouts = [{"stations": []} | each if isinstance(each, dict) else each for each in _renamed(given, DEEPEST)]
    report.translated("file", "names of LIF 2.0: parts are named as in 1.0 below, and layouts are counted over origins")
    if len(origins) > 1:
        names = ", ".join(str(origin.get("originId", "?")) for origin in origins[:5])
        report.without_effect("origins", f"{names}: each has its own coordinates; --shift X Y YAW moves a layout")
    return {"metaInformation": _renamed(tree.get("metaInformation"), DEEPEST), "layouts": layouts}


def _is_of_2(tree: Mapping[str, Any]) -> bool:
    layouts = [layout for layout in _list(tree.get("layouts")) if isinstance(layout, dict)]
    parts = [part for layout in layouts for name in ("nodes", "edges") for part in _list(layout.get(name))[:1]]
    return "origins" in tree or any(
        isinstance(part, dict) and part.keys() & NAMES.keys() for part in (*layouts, *parts)
    )


def _list(given: Any) -> list[Any]:
    return given if isinstance(given, list) else []


def _renamed(given: Any, depth: int) -> Any:
    if depth <= 0:
        return given
    if isinstance(given, list):
        return [each for part in given for each in _one_for_each_type(_renamed(part, depth - 1))]
    if isinstance(given, dict):
        return {NAMES.get(name, name): _renamed(value, depth - 1) for name, value in given.items()}
    return given


def _one_for_each_type(given: Any) -> list[Any]:
    """Return properties of several types of robots as those of one type each."""
    types = given.get(TYPES) if isinstance(given, dict) else None
    if not isinstance(types, list):
        return [given]
    rest = {name: value for name, value in given.items() if name != TYPES}
    return [rest | {TYPE: _type_of(each)} for each in types if isinstance(each, dict)] or [rest]


def _type_of(given: Mapping[str, Any]) -> str:
    names = [given.get(name) for name in ("manufacturer", "seriesName")]
    return ".".join(name for name in names if isinstance(name, str) and name)
