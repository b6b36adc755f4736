"""Names of a robot's frames, by its configuration."""

from engine.specs.containers import RobotConfig
from ppaas.nodes.frames import BASE_LINK, FrameNames


def base_frame(robot: RobotConfig | None) -> str:
    """Return the name of the frame in which a robot is driven; parameters that its container refuses do not count."""
    return BASE_LINK if robot is None else frame_names(robot).base


def frame_names(robot: RobotConfig) -> FrameNames:
    """Return the frame in which a robot is driven and its prefix; parameters that are not names do not count."""
    node, name = ("grid_slam", "base_frame") if robot.new_map else ("amcl", "base_frame_id")
    table = robot.parameters.get(node)
    given = table if isinstance(table, dict) else {}
    frame, prefix = given.get(name, BASE_LINK), given.get("tf_prefix", "")
    if not (isinstance(frame, str) and isinstance(prefix, str)):
        return FrameNames()
    return FrameNames.of("", frame, "", prefix)
