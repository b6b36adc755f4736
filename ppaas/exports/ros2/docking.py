"""Parameters of Nav2's docking server, and its file of docks, from the docks of a map and the types of a robot."""

import math
import re
from collections.abc import Iterable

import yaml

from ppaas.clone.driving import outline_of
from ppaas.docking.dock import MappedDock, docks_of
from ppaas.docking.failures import DockTypeUnknown
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.targets import DockTargets
from ppaas.exports.ros2.draft import SetupDraft
from ppaas.geometry import wrap_angle
from ppaas.parameters import read_parameters

SERVER, DOCKS_FILE = "docking_server", "docks.yaml"

SAME = (
    "controller_frequency", "initial_perception_timeout", "wait_charge_timeout", "dock_approach_timeout", "max_retries",
    "dock_prestaging_tolerance",
)  # fmt: skip
CONTROL = ("k_phi", "k_delta", "v_linear_min", "v_linear_max", "v_angular_max", "slowdown_radius")

NOT_IN_NAV2 = {
    "retry_offset": "further approaches of Nav2 are along the same axis",
    "patience": "Nav2 stops only before what its costmap shows, by controller.use_collision_detection",
    "lift_timeout": "Nav2 has no lift", "not_charging_timeout": "Nav2 does not watch docked robots",
    "next_docks": "Nav2 tries one dock a goal",
}  # fmt: skip

BY_POSE = {"pose", "april_tag"}
"""Detectors of poses on ``detected_dock_pose``, as Nav2's plug-ins take them."""


def add_docking(draft: SetupDraft) -> bytes | None:
    """Add the docking server for the docks of the map; return its file of docks, or None if the map has none."""
    found = draft.robot.map
    docks = () if found is None else docks_of(found.zones)
    if not docks:
        draft.unused(SERVER, "the map has no docks: draw zones of the kind 'dock'")
        return None
    given = read_parameters(DockingParameters, SERVER, draft.robot.given.get(SERVER, {}))
    plugins = _plugins(draft, DockTargets(given, outline_of(draft.robot.body)), docks)
    if not plugins:
        return None
    draft.put(f"{SERVER}.base_frame", "base_link")
    for name in SAME:
        draft.put(f"{SERVER}.{name}", getattr(given, name))
        draft.report.translated(f"{SERVER}.{name}", f"{SERVER}.{name}")
    for name in CONTROL:
        draft.put(f"{SERVER}.controller.{name}", getattr(given.controller, name))
    draft.report.translated(f"{SERVER}.controller", f"{SERVER}.controller")
    for name, why in NOT_IN_NAV2.items():
        if draft.robot.is_given(SERVER, name):
            draft.report.without_effect(f"{SERVER}.{name}", why)
    draft.put(f"{SERVER}.dock_plugins", sorted({plugin for plugin, _ in plugins.values()}))
    for plugin, kind in dict(plugins.values()).items():
        charges = any(dock.charges for dock, (name, _) in plugins.items() if name == plugin)
        _add_type(draft, plugin, kind, charges=charges)
    _set_direction(draft, [kind for _, kind in plugins.values()])
    return _docks_file(plugins)


def _plugins(
    draft: SetupDraft, targets: DockTargets, docks: Iterable[MappedDock]
) -> dict[MappedDock, tuple[str, DockType]]:
    """Return the name of the plug-in of each dock, and the settings of its type."""
    plugins = {}
    for each in docks:
        try:
            name, kind = targets.type_of(each.type)
        except DockTypeUnknown as error:
            draft.report.refused(each.in_words, str(error))
            continue
        dock = targets.target(each).dock
        plugins[dock] = re.sub(r"\W", "_", name) + ("" if dock.charges else "_without_charge"), kind
    return plugins


def _add_type(draft: SetupDraft, plugin: str, kind: DockType, *, charges: bool) -> None:
    """Add a plug-in for a type of docks."""
    place, has_other = f"{SERVER}.{plugin}", not draft.release.is_humble
    is_charging = charges or not has_other
    draft.put(f"{place}.plugin", f"opennav_docking::Simple{'' if is_charging else 'Non'}ChargingDock")
    draft.put(f"{place}.staging_x_offset", -kind.staging_distance)
    if kind.dock_direction == "backward":
        draft.put(f"{place}.staging_yaw_offset", math.pi)
    draft.put(f"{place}.docking_threshold", kind.docking_threshold)
    if is_charging:
        draft.put(f"{place}.use_battery_status", charges)
        draft.put(f"{place}.charging_threshold", kind.charging_threshold)
    draft.put(f"{place}.use_external_detection_pose", kind.detection != "map")
    part, why = f"{SERVER}.dock_types.{plugin}", f"{place}.plugin"
    if kind.detection in BY_POSE:
        why += ": measure external_detection_translation_x and the rotations at the dock"
    elif kind.detection != "map":
        draft.report.refused(part, f"Nav2 has no detector {kind.detection}: a node has to publish detected_dock_pose")
        return
    draft.report.translated(part, why)
    if kind.load:
        draft.report.without_effect(f"{part}.load", "Nav2 has no lift")


def _set_direction(draft: SetupDraft, kinds: list[DockType]) -> None:
    """Set whether robots dock backwards: for all docks in releases in which the types do not say so."""
    backwards = {kind.dock_direction == "backward" for kind in kinds}
    if True not in backwards:
        return
    draft.put(f"{SERVER}.dock_backwards", True)
    if len(backwards) > 1:
        why = "the docking server drives into all docks backwards: give it another one for those ahead"
        draft.report.refused(f"{SERVER}.dock_types", why)


def _docks_file(plugins: dict[MappedDock, tuple[str, DockType]]) -> bytes:
    """Return the file of docks. A dock of Nav2 points into the dock, also for robots that stand there backwards."""
    docks = {}
    for number, (dock, (plugin, kind)) in enumerate(plugins.items(), 1):
        turn = math.pi if kind.dock_direction == "backward" else 0.0
        pose = [dock.pose.x, dock.pose.y, wrap_angle(dock.pose.theta + turn)]
        docks[dock.name or f"dock {number}"] = {
            "type": plugin,
            "frame": "map",
            "pose": [round(each, 4) for each in pose],
        }
    return yaml.safe_dump({"docks": docks}, sort_keys=False, default_flow_style=None).encode()
