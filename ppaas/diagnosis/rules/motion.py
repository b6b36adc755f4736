"""Rules on motion: a base that does not follow commands, reversed signs, odometry that jumps, several commanders."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import MotionFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, error, warn
from ppaas.nodes import topics

ORDERED = 0.3
"""Path of commands from which the base must have moved [m]."""

FOLLOWED = 0.2
"""Part of the ordered path below which the base does not follow, as Move Base has it."""

TURNED, DRIVEN = 0.5, 0.2
"""Angle [rad] and distance [m] of commands from which their signs can be compared."""

REVERSED = -0.3
"""Part of what was ordered below which the sign is reversed."""

JUMP = 0.5
"""Distance between two messages of the odometry from which it jumped [m]."""


def motion(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the motion of the robot."""
    facts = seen.motion
    yield from _following(seen, facts)
    if facts.jump > JUMP:
        text = f"Odometry jumped by {facts.jump:.1f} m between two messages."
        advice = "Odometry is smooth: it must not be reset or corrected by a map. Publish corrected poses elsewhere."
        yield warn("odom-jumps", text, advice, topics.ODOM.name)
    commands = seen.topic(topics.CMD_VEL.name)
    if commands.senders and not seen.on_robot("move_base"):
        text = "Another client publishes on 'cmd_vel' beside Move Base."
        yield warn("cmd-vel-others", text, "Stop it while the cloud drives, for example a teleoperation.", "cmd_vel")


def _following(seen: Observations, facts: MotionFacts) -> Iterator[Finding]:
    if facts.ordered_path < ORDERED or seen.topic(topics.ODOM.name).silence is None:
        return
    if facts.moved_path < FOLLOWED * facts.ordered_path:
        text = (
            f"The robot was ordered to drive {facts.ordered_path:.1f} m by cmd_vel in the last seconds, and its "
            f"odometry moved {facts.moved_path:.2f} m."
        )
        advice = (
            "The base does not obey, or its odometry stands still: look at the emergency stop, at the motors, at the "
            "subscription of the base to 'cmd_vel' (Twist or TwistStamped), and at the encoders."
        )
        yield error("base-does-not-follow", text, advice, "cmd_vel")
    elif _reversed(facts.ordered_turn, facts.moved_turn, TURNED):
        text = (
            f"cmd_vel turned the robot by {facts.ordered_turn:+.1f} rad, but odometry turned by "
            f"{facts.moved_turn:+.1f} rad: one of them has the wrong sign."
        )
        advice = "A positive angular.z turns left. Swap the motors, or the sign of the yaw of the odometry."
        yield error("turn-reversed", text, advice, "odom")
    elif _reversed(facts.ordered, facts.moved, DRIVEN):
        text = (
            f"cmd_vel drove the robot by {facts.ordered:+.1f} m, but odometry moved by {facts.moved:+.1f} m: one of "
            "them has the wrong sign."
        )
        yield error("drive-reversed", text, "A positive linear.x drives forward, along x of base_link.", "odom")


def _reversed(ordered: float, moved: float, least: float) -> bool:
    return abs(ordered) > least and moved / ordered < REVERSED
