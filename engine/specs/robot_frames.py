"""Names of a robot's frames, by its configuration."""

from engine.specs.containers import RobotConfig
from ppaas.nodes.frames import BASE_LINK, FrameNames


def base_frame(robot: RobotConfig | None) -> str:
    """Return the name of the frame in which a robot is driven; parameters that its container refuses do not count."""
    amcl = robot.parameters.get("amcl") if robot is not None else None
    given = amcl if isinstance(amcl, dict) else {}
    frame, prefix = given.get("base_frame_id", BASE_LINK), given.get("tf_prefix", "")
    if not (isinstance(frame, str) and isinstance(prefix, str)):
        return BASE_LINK
    return FrameNames.of("", frame, "", prefix).base
