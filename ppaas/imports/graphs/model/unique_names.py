"""Names of a foreign file as names that this project takes, each once."""

import re
from collections.abc import Collection

LONGEST = 64
"""Length of a name of a floor or a lift, and of the id of a map."""


def unique_name(text: str, taken: Collection[str], refused: str = r"[/\x00-\x1f]+") -> str:
    """Return a name without the characters that are refused, which is not taken; a number is added if it is.

    Parameters
    ----------
    text : str
    taken : collection of str
    refused : str
        Pattern of what is replaced by a hyphen.
    """
    wanted = re.sub(refused, "-", " ".join(text.split()))[:LONGEST] or "unnamed"
    found, number = wanted, 1
    while found in taken:
        number += 1
        end = f"-{number}"
        found = wanted[: LONGEST - len(end)] + end
    return found
