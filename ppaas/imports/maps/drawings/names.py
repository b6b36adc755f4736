"""Names of layers and elements of floor plans that are no walls, in the languages of common templates."""

import re

_DOORS = re.compile(
    r"(?<!in)(?<!out)doors?(?!step|way)|\bdr\b|t(?:ü|ue)r(?:en)?(?![a-z])|\b(?:porte?s?|portas?|deur(?:en)?)\b|puerta",
    re.IGNORECASE,
)
_OTHERS = re.compile(
    r"\bdim|bema(?:ß|ss)|\btexts?\b|\banno|\bnotes?\b|\blabels?\b|\btitle|\blegend|\bgrid\b|\baxis\b|\bachsen?\b|furn|"
    r"m(?:ö|oe)bel|mobili|schraff|defpoints|viewport|\bframe\b|rahmen\b",
    re.IGNORECASE,
)
_BETWEEN = re.compile(r"[_\-.$|/]+")


def is_door(name: str) -> bool:
    """Return whether a name is one of doors."""
    return bool(_DOORS.search(_BETWEEN.sub(" ", name)))


def is_other(name: str) -> bool:
    """Return whether a name is one of dimensions, texts, furniture or other things that are no walls."""
    return bool(_OTHERS.search(_BETWEEN.sub(" ", name)))
