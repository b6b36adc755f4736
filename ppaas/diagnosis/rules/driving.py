"""Rules on goals, commands and motion: why there is no ``cmd_vel``, why a goal ended, how the base moves."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import GoalFacts, MotionFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, capital, error, hertz, ok, warn
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.operators.teleoperation import TeleopMode
from ppaas.nodes import topics

ENDED = frozenset(status for status in Status if status.terminal)
"""Statuses of goals that have ended."""

CMD_VEL = topics.CMD_VEL.name


def goals(seen: Observations) -> Iterator[Finding]:
    """Yield whether the robot has a goal, what Move Base does for it, and who gets the commands."""
    yield from _subscriber(seen)
    goal = seen.goal
    if seen.stopped:
        yield _stopped(seen)
    elif seen.hand.driver:
        yield _by_hand(seen)
    elif not goal.name or _ended(goal):
        yield from _without_goal(seen, goal)
    elif goal.text.startswith("waiting"):
        reason = goal.text.partition(": ")[2] or goal.text
        text = capital(f"move Base waits and sends no cmd_vel but zero: {reason}")
        yield error("goal-waits", text, "Mend what it names; it continues by itself.", CMD_VEL)
    elif goal.text.startswith("recovering"):
        text = capital(f"move Base is {goal.text}")
        yield warn("goal-recovers", text, "Mend what it names; if it names nothing, look for obstacles.", CMD_VEL)
    elif seen.follows_paths:
        text = f"The robot is led along paths, which it follows itself ({goal.text or 'no text'})."
        yield ok("goal-active", text, "", topics.FOLLOW_PATH_GOAL.name)
    elif not seen.motion.commands:
        text = f"A goal is active ({goal.text or 'no text'}), and no cmd_vel was sent while the robot was watched."
        yield ok("goal-plans", text, "Move Base plans; watch again in some seconds.", CMD_VEL)
    else:
        text = f"Move Base drives: cmd_vel is sent at {hertz(seen.topic(CMD_VEL).rate)} ({goal.text or 'no text'})."
        yield ok("goal-active", text, "", CMD_VEL)


def _stopped(seen: Observations) -> Finding:
    waits = "" if not seen.goal.name or _ended(seen.goal) else " Its goal waits."
    text = f"The robot is stopped, and gets nothing but zero as cmd_vel: {seen.stopped}.{waits}"
    advice = (
        f"When it may drive on: 'ppaas release {seen.robot}', or by the name of the stop ('ppaas stop' lists them)."
    )
    return error("robot-stopped", text, advice, topics.STOP_STATE.name)


def _by_hand(seen: Observations) -> Finding:
    hand = seen.hand
    name, topic = "driven-by-hand", topics.TELEOP_STATE.name
    text = f"{hand.driver} drives the robot by hand, and no other goal is taken meanwhile"
    match hand.mode:
        case TeleopMode.LOCKED:
            text, advice = f"{text}; it stands: {hand.text}.", "The driver lets go of the control and presses it again."
            return warn(name, text, advice, topic)
        case TeleopMode.BLOCKED:
            advice = "Drive in another direction; if nothing is there, see what the local costmap shows."
            return warn(name, f"{text}; something is in the way.", advice, topic)
    return ok(name, f"{text}.", "Wait until they stop driving, or take over in the dashboard.", topic)


def _ended(goal: GoalFacts) -> bool:
    return goal.status in ENDED


def _without_goal(seen: Observations, goal: GoalFacts) -> Iterator[Finding]:
    how = f"Send one: 'ppaas robot go {seen.robot} X Y', 'Drive' in the dashboard, or 'move_base_simple/goal'."
    if goal.name and goal.status in (Status.ABORTED, Status.REJECTED, Status.LOST):
        word = {Status.ABORTED: "was aborted", Status.REJECTED: "was rejected"}.get(Status(goal.status), "was lost")
        text = capital(f"the last goal {word}: {goal.text or 'without a reason'}")
        yield warn("goal-failed", text, f"No cmd_vel is sent without a goal. {how}", topics.MOVE_BASE_RESULT.name)
        return
    yield ok("no-goal", "No goal is active, so no cmd_vel is sent.", how, CMD_VEL)


def _subscriber(seen: Observations) -> Iterator[Finding]:
    link = seen.link
    heard = topics.FOLLOW_PATH_GOAL.name if seen.follows_paths else CMD_VEL
    if link is None or link.robots == 0 or heard in link.subscribed or seen.on_robot("move_base"):
        return
    if seen.follows_paths:
        text = f"The robot follows paths itself by its file, and does not subscribe to '{heard}': no path reaches it."
        advice = "Subscribe to it in the role robot; or remove 'follow_path' from the parameters in its file."
        yield error("paths-unheard", text, advice, heard)
        return
    text = "The robot does not subscribe to 'cmd_vel': no command of the cloud reaches it."
    advice = "Subscribe to 'cmd_vel' as geometry_msgs/Twist or geometry_msgs/TwistStamped, in the role robot."
    yield error("cmd-vel-unheard", text, advice, CMD_VEL)


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
