"""Depth of YAML: files that are nested so deeply that the parser would crash are refused before it sees them."""

import yaml

from ppaas.errors import InvalidInput

MAX_DEPTH = 64
"""Largest depth of nesting."""

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_BEGINS = (yaml.SequenceStartEvent, yaml.MappingStartEvent)
_ENDS = (yaml.SequenceEndEvent, yaml.MappingEndEvent)


def check_depth(content: bytes, source: str) -> None:
    """Check the depth of YAML: the composer of libyaml recurses in C, and 100 kB of brackets end the process.

    Parameters
    ----------
    content : bytes
    source : str
        Name of the file, for people.

    Raises
    ------
    InvalidInput
        It is nested more than `MAX_DEPTH` deep.
    yaml.YAMLError
        It is no YAML.
    """
    depth = 0
    for event in yaml.parse(content, Loader=_LOADER):
        if isinstance(event, _BEGINS):
            depth += 1
            if depth > MAX_DEPTH:
                where = "" if event.start_mark is None else f", in line {event.start_mark.line + 1}"
                raise InvalidInput(f"{source} is nested more than {MAX_DEPTH} deep{where}")
        elif isinstance(event, _ENDS):
            depth -= 1
