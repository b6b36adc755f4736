"""Lookup of a user by an id that a stranger gives."""

from starlette.concurrency import run_in_threadpool

from ppaas.errors import NotFound
from storage.names import is_name
from storage.ports import UserStore
from storage.records import User


async def find_user(store: UserStore, user_id: str) -> User | None:
    """Return a user; None if the user does not exist, or the id is not a name."""
    if not is_name(user_id):
        return None
    try:
        return await run_in_threadpool(store.user, user_id)
    except NotFound:
        return None
