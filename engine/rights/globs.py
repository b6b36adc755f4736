"""Globs of topics, services, actions and robots, as of the shell: ``*``, ``?``, ``[abc]``; ``*`` also matches slashes.

``rosbridge_suite`` matches its ``topics_glob`` alike.
"""

import re
from collections.abc import Iterable
from fnmatch import fnmatchcase

from storage.names import PATTERN
from storage.sharing_records import TokenScope

MAX_GLOB = 128
"""Largest glob [characters]."""

MAX_GLOBS = 64
"""Largest number of globs in one list."""

GLOB = rf"/?[A-Za-z0-9_.*?\[\]!-][A-Za-z0-9_.*?\[\]!/-]{{0,{MAX_GLOB - 2}}}"
"""Pattern of globs of topics, services and actions."""

ROBOT_GLOB = r"([A-Za-z0-9_.*?\[\]!-]{1,64}:)?[A-Za-z0-9_.*?\[\]!-]{1,64}"
"""Pattern of globs of robots."""

ADDRESS = f"({PATTERN}:)?{PATTERN}"
"""Pattern of addresses of robots: ``ROBOT``, or ``OWNER:ROBOT``."""

_ADDRESS = re.compile(ADDRESS)


def matches(name: str, globs: Iterable[str]) -> bool:
    """Return whether a name matches one of some globs."""
    return any(fnmatchcase(name, glob) for glob in globs)


def bare(glob: str) -> str:
    """Return a glob of topics without the leading slash, as names are in rights."""
    return glob.removeprefix("/")


def is_in_scope(scope: TokenScope, user: str, owner: str, robot: str) -> bool:
    """Return whether a token of a user is for a robot; a glob without an owner is for robots of the user alone."""
    for glob in scope.robots:
        of, colon, name = glob.rpartition(":")
        if (fnmatchcase(owner, of) if colon else owner == user) and fnmatchcase(robot, name):
            return True
    return False


def is_address(text: str) -> bool:
    """Return whether a text is ``ROBOT`` or ``OWNER:ROBOT``."""
    return _ADDRESS.fullmatch(text) is not None


def split_address(address: str, user: str) -> tuple[str, str]:
    """Return owner and id of a robot by its address; the owner is the user if the address names none."""
    owner, colon, robot = address.rpartition(":")
    return (owner if colon else user), robot
