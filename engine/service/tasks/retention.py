"""Retention of tasks that have ended."""

from collections.abc import Sequence

from ppaas.tasks.records import Task

KEPT_FOR = 7 * 86400.0
"""Time for which a task is kept after its end [s]."""

MOST_ENDED = 1000
"""Number of ended tasks of a user on a map that are kept; the oldest are removed first."""


def obsolete(tasks: Sequence[Task], now: float) -> list[str]:
    """Return the ids of the tasks that are not kept any longer.

    Parameters
    ----------
    tasks : sequence of Task
        Tasks of a user on a map.
    now : float
        Time [s since the epoch].
    """
    ended = sorted(((task.ended or 0.0, task.id) for task in tasks if not task.is_open), reverse=True)
    kept = {name for at, name in ended[:MOST_ENDED] if now - at <= KEPT_FOR}
    return [name for _, name in ended if name not in kept]
