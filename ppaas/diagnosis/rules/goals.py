"""Rules on goals and commands: why there is no ``cmd_vel``, and why a goal ended."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import GoalFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, error, ok, warn
from ppaas.diagnosis.rules.words import capital, hertz
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes import topics

ENDED = frozenset(status for status in Status if status.terminal)
"""Statuses of goals that have ended."""

CMD_VEL = topics.CMD_VEL.name


def goals(seen: Observations) -> Iterator[Finding]:
    """Yield whether the robot has a goal, what Move Base does for it, and who gets the commands."""
    yield from _subscriber(seen)
    goal = seen.goal
    if not goal.name or _ended(goal):
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
