"""Robot of a client that names none: the only one of its user."""

from starlette.concurrency import run_in_threadpool

from endpoints.sharing.shared_robots import own_robots
from ppaas.errors import InvalidParameter
from storage.ports import RobotStore
from storage.records import RobotRecord, User

MAX_LISTED = 10
"""Largest number of robots that the refusal lists."""


async def only_robot(store: RobotStore, user: User) -> str:
    """Return the id of the only robot of a user, or the only one that the user's token is for.

    Raises
    ------
    InvalidParameter
        The user has none, or several, which the text lists.
    """
    robots = [robot.id for robot in await run_in_threadpool(_first_robots, store, user)]
    if len(robots) == 1:
        return robots[0]
    if not robots:
        raise InvalidParameter(
            f"user {user.id!r} has no robot yet: register one with 'ppaas robot put' or PUT /v1/robots/ID"
        )
    listed = ", ".join(robots[:MAX_LISTED]) + (", …" if len(robots) > MAX_LISTED else "")
    raise InvalidParameter(f"user {user.id!r} has several robots: open ws://HOST/?robot=ID with one of {listed}")


def _first_robots(store: RobotStore, user: User) -> list[RobotRecord]:
    return own_robots(store, user, limit=MAX_LISTED + 1)
