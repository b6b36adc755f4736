"""Users whom a request names. They must exist: the next user of a misspelled name would get the rights of another.

Shares of robots, readers of maps and members of groups are checked here.
"""

from collections.abc import Iterable

from ppaas.errors import NotFound, listed
from storage.ports import MapStore, UserStore
from storage.records import User
from storage.sharing_records import GROUP

EVERYBODY = "*"
"""Reader of a map that stands for all users."""

_ADVICE = "check the spelling, or let an administrator create"


def check_users(store: UserStore, names: Iterable[str]) -> list[User]:
    """Return users by their names; may block.

    Raises
    ------
    NotFound
        Some do not exist, or are being removed; the text names all of these.
    """
    found, unknown = [], []
    for name in dict.fromkeys(names):
        user = _user(store, name)
        if user is None:
            unknown.append(name)
        else:
            found.append(user)
    if unknown:
        them = "that user" if len(unknown) == 1 else "these users"
        command = f"{_ADVICE} {them} with 'ppaas user create'"
        raise NotFound("user" if len(unknown) == 1 else "users", listed(unknown), advice=command)
    return found


def _user(store: UserStore, name: str) -> User | None:
    try:
        user = store.user(name)
    except NotFound:
        return None
    return None if user.leaving else user


def check_grantee(store: UserStore, grantee: str) -> None:
    """Raise ``NotFound`` unless a user exists, or a group has a member; may block."""
    if not grantee.startswith(GROUP):
        check_users(store, [grantee])
        return
    group = grantee.removeprefix(GROUP)
    if not any(group in user.groups for user in store.users() if not user.leaving):
        raise NotFound("group", group, advice=f"{_ADVICE} that group with 'ppaas user group'")


def check_readers(store: UserStore, maps: MapStore, map_id: str, readers: Iterable[str]) -> None:
    """Raise ``NotFound`` unless the readers that a map is to have exist, or are its readers already; may block."""
    try:
        known = maps.map_head(map_id).readers
    except NotFound:
        known = ()
    check_users(store, (reader for reader in readers if reader != EVERYBODY and reader not in known))
