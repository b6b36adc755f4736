"""Values that depend on several parameters: limits that must suit each other, and the start of the robot."""

from collections.abc import Callable
from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.nav2.writer import DraftWriter, Parts
from ppaas.imports.parameters.values import FINEST_OF_MPPI, flag, number

_Limit = tuple[int, str, Callable[[float, float], float]]

LIMITS: dict[str, tuple[_Limit, ...]] = {
    "max_velocity": ((0, "max_vel_x", min), (2, "max_vel_theta", min)),
    "min_velocity": ((0, "min_vel_x", max),),
    "max_accel": ((0, "acc_lim_x", min), (2, "acc_lim_theta", min)),
    "deadband_velocity": ((0, "min_vel_trans", max), (2, "min_vel_theta", max)),
}
"""Axis in the list, our limit, and which of two values counts, by the smoother's parameters."""

SLOWEST, SLOWEST_TURN = 0.05, 0.2
"""Defaults of ``min_vel_trans`` [m/s] and ``min_vel_theta`` [rad/s] of local planners."""

TURN_TO_PATH = 1.8
"""Default of ``rotate_to_heading_angular_vel`` [rad/s]."""


def smoothed(writer: DraftWriter, parts: Parts) -> None:
    """Apply the limits of the velocity smoother to the local planner, where they are stricter."""
    for name, (part, given) in parts.items():
        try:
            numbers = [number(each) for each in given.value] if isinstance(given.value, list) else []
        except InvalidParameter as error:
            writer.report.refused(part, f"a number of the list: {error}", given.line)
            continue
        if len(numbers) not in (3, 6):
            writer.report.refused(part, f"it must be a list of x, y and theta, not {given.value!r}", given.line)
            continue
        places = [(limit, which, _of_axis(numbers, axis)) for axis, limit, which in LIMITS[name]]
        if not _stricter(writer, part, given.line, places):
            writer.report.without_effect(part, "the local planner keeps to these limits", given.line)


def _of_axis(numbers: list[float], axis: int) -> float:
    return numbers[axis if len(numbers) == 3 or axis == 0 else 5]


def _stricter(
    writer: DraftWriter, part: str, line: int, places: list[tuple[str, Callable[[float, float], float], float]]
) -> bool:
    """Set those limits of the local planner that are not as strict; return whether there are any."""
    changed = False
    for limit, which, value in places:
        now = writer.of_controller().get(limit)
        if now is None and limit.startswith("min_") and value <= 0.0:
            continue
        if now is not None and not isinstance(now, int | float):
            continue
        if now is None or which(now, value) != now:
            place = f"parameters.{writer.controller}.{limit}"
            writer.translate(place, value, part, "the limit of the velocity smoother", line)
            changed = True
    return changed


def fit_limits(writer: DraftWriter) -> None:
    """Add those limits without which the clone would refuse the translated ones, and report them."""
    given = writer.of_controller()
    top, turn = _number(given, "max_vel_x"), _number(given, "max_vel_theta")
    if top is not None and 0.0 < top < _number(given, "min_vel_trans", SLOWEST):
        _fit(writer, "min_vel_trans", top, "not above max_vel_x")
    if turn is not None and 0.0 < turn < _number(given, "min_vel_theta", SLOWEST_TURN):
        _fit(writer, "min_vel_theta", turn, "not above max_vel_theta")
    if writer.controller == "mppi" and 0.0 <= _number(given, "xy_goal_tolerance", 1.0) < FINEST_OF_MPPI:
        _fit(writer, "xy_goal_tolerance", FINEST_OF_MPPI, "mppi does not come to rest nearer to a goal")
    if writer.controller == "pure_pursuit":
        turns = _number(given, "rotate_to_heading_angular_vel", TURN_TO_PATH)
        if 0.0 < turns < _number(given, "min_vel_theta", SLOWEST_TURN):
            _fit(writer, "min_vel_theta", turns, "not above rotate_to_heading_angular_vel")
        if given.get("allow_reversing") is True and _number(given, "min_vel_x", 0.0) >= 0.0:
            _fit(writer, "min_vel_x", -(top or SLOWEST), "as fast in reverse as forward")
        _fit_lookahead(writer)
    _fit_ranges(writer)
    if "footprint" in writer.draft.get("parameters", {}).get("global_costmap", {}):
        writer.drop("parameters.global_costmap.robot_radius", "the footprint counts, since there is one")


def _fit_lookahead(writer: DraftWriter) -> None:
    """Widen the range of lookahead distances, of which a file may give only one end."""
    given = writer.of_controller()
    least, most = _number(given, "min_lookahead_dist"), _number(given, "max_lookahead_dist")
    if least is not None and most is None and least > 0.9:
        _fit(writer, "max_lookahead_dist", least, "not below min_lookahead_dist")
    if most is not None and least is None and most < 0.3:
        _fit(writer, "min_lookahead_dist", most, "not above max_lookahead_dist")


def _fit_ranges(writer: DraftWriter) -> None:
    """Keep beams from clearing obstacles that they may not mark."""
    local: dict[str, Any] = writer.draft.get("parameters", {}).get("local_costmap", {})
    marks, clears = _number(local, "obstacle_range"), _number(local, "raytrace_range", 3.0)
    if marks is not None and clears > marks > 0.0:
        place = "parameters.local_costmap.raytrace_range"
        writer.translate(place, marks, "local_costmap", "beams clear no farther than they mark")


def _fit(writer: DraftWriter, limit: str, value: float, text: str) -> None:
    place = f"parameters.{writer.controller}.{limit}"
    writer.translate(place, value, f"limits of {writer.controller}", text)


def _number(table: dict[str, Any], name: str, default: Any = None) -> Any:
    found = table.get(name, default)
    return found if isinstance(found, int | float) and not isinstance(found, bool) else default


# -- start of the robot ----------------------------------------------------------------------------------------------

SWITCH = "set_initial_pose"
COORDINATES = ("initial_pose.x", "initial_pose.y", "initial_pose.yaw")
START = frozenset((SWITCH, *COORDINATES))
"""Names of the parameters."""

UNUSED = "set_initial_pose is not true: the field initial_pose of the robot file gives the start"


def add_start(writer: DraftWriter, parts: Parts) -> None:
    """Add the initial pose to a draft, if the file sets it."""
    report = writer.report
    try:
        sets = SWITCH in parts and flag(parts[SWITCH][1].value)
        pose = [number(parts[name][1].value) if name in parts else 0.0 for name in COORDINATES]
    except InvalidParameter as error:
        for part, given in parts.values():
            report.refused(part, f"the initial pose cannot be read: {error}", given.line)
        return
    for name, (part, given) in parts.items():
        if not sets:
            report.without_effect(part, UNUSED, given.line)
        elif name == SWITCH:
            writer.translate("initial_pose", pose, part, "x, y [m] and yaw [rad]", given.line)
        else:
            report.translated(part, "part of initial_pose", given.line)
