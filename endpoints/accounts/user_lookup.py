"""Lookup of a user by an id that a stranger gives."""

from starlette.concurrency import run_in_threadpool

from ppaas.errors import NotFound
from storage.names import is_name
from storage.ports import UserStore
from storage.records import User

MAX_COUNTED = 128
"""Length to which names are cut for counters [characters]; no user has such a long name."""


async def find_user(store: UserStore, user_id: str) -> User | None:
    """Return a user; None if the user does not exist, or the id is not a name."""
    if not is_name(user_id):
        return None
    try:
        return await run_in_threadpool(store.user, user_id)
    except NotFound:
        return None


def counted_name(user_id: str) -> str:
    """Return the name under which attempts to log in are counted: of bounded length, and valid Unicode."""
    return user_id[:MAX_COUNTED].encode("utf-8", "replace").decode()
