"""Names of a robot's frames, by its configuration."""

from engine.specs.containers import RobotConfig
from ppaas.nodes.frames import BASE_LINK, FrameNames


def base_frame(robot: RobotConfig | None) -> str:
    """Return the name of the frame in which a robot is driven; parameters that its container refuses do not count."""
    if robot is None:
        return BASE_LINK
    node, name = ("grid_slam", "base_frame") if robot.new_map else ("amcl", "base_frame_id")
    table = robot.parameters.get(node)
    given = table if isinstance(table, dict) else {}
    frame, prefix = given.get(name, BASE_LINK), given.get("tf_prefix", "")
    if not (isinstance(frame, str) and isinstance(prefix, str)):
        return BASE_LINK
    return FrameNames.of("", frame, "", prefix).base
