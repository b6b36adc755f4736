"""Names that stores take: of users, maps, robots and plans.

One rule for all, narrow enough to be a file name, a column, a URL segment and a Zenoh key at once: no slash, no
leading dot, nothing that needs quoting.
"""

import re

from ppaas.errors import InvalidInput

PATTERN = "[A-Za-z0-9][A-Za-z0-9_.-]{0,63}"
_NAME = re.compile(PATTERN)


def is_name(name: str) -> bool:
    """Tell whether stores take a name."""
    return _NAME.fullmatch(name) is not None


def check_name(kind: str, name: str) -> str:
    """Return the name.

    Parameters
    ----------
    kind : str
        What it names, for the text of the error.

    Raises
    ------
    InvalidInput
        It cannot be one.
    """
    if not is_name(name):
        shown = name if len(name) <= 64 else name[:64] + "…"
        raise InvalidInput(
            f"{shown!r} cannot name a {kind}: take 1 to 64 letters, digits, '_', '.' and '-', a letter or digit first"
        )
    return name
