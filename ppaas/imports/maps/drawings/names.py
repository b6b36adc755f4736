"""Names of layers and elements of floor plans that are no walls, in the languages of common templates."""

import re

_DOORS = re.compile(r"door|\bdr\b|t[uü]e?r(?![a-z]*m)|porte|puerta|porta\b|deur", re.IGNORECASE)
_OTHERS = re.compile(
    r"\bdim|bema[sß]|text|anno|note|label|title|legend|grid|axis|achse|furn|m[oö]bel|mobili|hatch|schraff|defpoints|"
    r"viewport|border|rahmen|area-iden|zone",
    re.IGNORECASE,
)


def is_door(name: str) -> bool:
    """Return whether a name is one of doors."""
    return bool(_DOORS.search(name.replace("_", " ").replace("-", " ")))


def is_other(name: str) -> bool:
    """Return whether a name is one of dimensions, texts, furniture or other things that are no walls."""
    return bool(_OTHERS.search(name.replace("_", " ")))
