"""States of goals of robots, by the statuses of actions."""

from typing import Literal

from ppaas.messages.actionlib_msgs import Status

GoalState = Literal["pending", "active", "succeeded", "canceled", "aborted", "rejected", "lost"]

STATES: dict[Status, GoalState] = {
    Status.PENDING: "pending",
    Status.ACTIVE: "active",
    Status.PREEMPTING: "active",
    Status.RECALLING: "active",
    Status.SUCCEEDED: "succeeded",
    Status.PREEMPTED: "canceled",
    Status.RECALLED: "canceled",
    Status.ABORTED: "aborted",
    Status.REJECTED: "rejected",
    Status.LOST: "lost",
}
"""State of a goal by its status."""
