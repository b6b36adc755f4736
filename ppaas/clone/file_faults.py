"""Finds all faults of a robot file by the check of a clone, which stops at the first.

The part that is at fault is found by leaving it out: without it, the check finds another fault or none. So only the
clone has the rules.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from ppaas.errors import RobotFault

MOST_FAULTS = 20
"""Largest number of faults that are listed."""

File = Mapping[str, Any]

Check = Callable[[File], str | None]
"""Returns the first fault of a file, or None."""

_Path = tuple[str | int, ...]

_SECTION = 2
"""Length of the path of all parameters of one node or plug-in."""

_PLUGINS = frozenset({"base_global_planner", "base_local_planner", "recovery_behaviors"})
"""Parameters that name plug-ins; if a name is wrong, no plug-in takes the parameters under it."""


class _Found(NamedTuple):
    path: _Path
    text: str
    file: File


def all_faults(file: File, check: Check, may_go_on: Callable[[], bool] = lambda: True) -> list[RobotFault]:
    """Return the faults of a file, in the order in which its clone finds them; none if it is accepted.

    Parameters
    ----------
    file : mapping
        Values of JSON; parts that are left out have their defaults.
    check : callable
        Returns the first fault of such a file.
    may_go_on : callable
        Returns whether there is time for more checks; without it, the faults found so far are returned.
    """
    return _Search(check, may_go_on).faults_of(file)


class _Search:
    """Search for the faults of one file."""

    def __init__(self, check: Check, may_go_on: Callable[[], bool]) -> None:
        self._check = check
        self._may_go_on = may_go_on

    def faults_of(self, file: File) -> list[RobotFault]:
        """Return the faults of a file; each is found once those before are left out."""
        found: list[_Found] = []
        text = self._check(file)
        while text is not None and len(found) < MOST_FAULTS:
            path = self._culprit(file, text)
            if not self._follows(found, path):
                found.append(_Found(path, text, file))
            if not path or not self._may_go_on():
                break
            file = _without(file, path)
            text = self._check(file)
        return [RobotFault(".".join(map(str, each.path)), each.text) for each in found]

    def _culprit(self, file: File, text: str, path: _Path = ()) -> _Path:
        """Return the path of the smallest part, below a path, without which there is no such fault; or this path."""
        other: _Path | None = None
        for step in sorted(_steps(file, path), key=lambda step: _is_named(step, text), reverse=True):
            if not self._may_go_on():
                break
            tried = (*path, step)
            first = self._check(_without(file, tried))
            if first is None:  # rather than a part whose lack is another fault
                return self._culprit(file, text, tried)
            if first != text and other is None:
                other = tried
        return path if other is None else self._culprit(file, text, other)

    def _follows(self, found: list[_Found], path: _Path) -> bool:
        """Return whether a fault is only there because others were left out, or is the other half of one."""
        if len(path) == _SECTION and any(_PLUGINS.intersection(map(str, each.path)) for each in found):
            return True
        return bool(path) and any(self._check(_without(each.file, path)) != each.text for each in found)


def _steps(file: File, path: _Path) -> Iterator[str | int]:
    """Return the parts at a path that may be left out: fields, sections, parameters, objects in a list."""
    part: Any = file
    for step in path:
        part = part[step]
    if isinstance(part, Mapping) and len(path) <= _SECTION:
        yield from part
    elif isinstance(part, list) and all(isinstance(each, Mapping) for each in part):
        yield from range(len(part))


def _without(part: Any, path: _Path) -> Any:
    """Return a file without the part at a path."""
    step, rest = path[0], path[1:]
    if isinstance(part, list):
        return [each for index, each in enumerate(part) if index != step]
    if not rest:
        return {name: value for name, value in part.items() if name != step}
    return {**part, step: _without(part[step], rest)}


def _is_named(step: str | int, text: str) -> bool:
    """Return whether an error text names a part, apart from the valid names that it lists."""
    return str(step) in text.partition("; known:")[0]
