"""Robot file of several translations and the user's own one, of which the clone accepts every translated value."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from ppaas.clone.file_faults import all_faults
from ppaas.controllers.registry import CONTROLLERS
from ppaas.imports.parameters.rules import put
from ppaas.imports.report import ImportOutcome, ImportReport
from ppaas.navigation.parameters import MoveBaseParameters

Draft = dict[str, Any]
"""Part of a robot file, as a tree of values of JSON, written by ``rules.put``."""

Translation = tuple[Draft, ImportReport]
"""What an import of a parameter file returns: the draft, and what became of each parameter."""

Refusal = Callable[[Mapping[str, Any]], str | None]
"""Returns why a robot file is refused, or None: ``ppaas.imports.parameters.clone_check.refusal``."""

PARAMETERS = "parameters"

MAP = "map"
"""Field of a robot file that names its map."""

NAME = "base_local_planner"
"""Field of a robot file, and parameter of Move Base, that names the local planner."""

_NAMED = 3
"""Depth of a parameter: ``parameters``, node or plug-in, name."""


def robot_file(translations: Sequence[Translation], own: Mapping[str, Any], refusal: Refusal) -> Draft:
    """Merge translations and a user's own robot file into one that its clone accepts.

    The own file wins over all translations, and a later translation over an earlier one. Translated values that lose,
    or that the clone refuses, are left out, and the entries of the reports say so. Values of the own file stay even if
    the clone refuses them: the cloud does, too.

    Parameters
    ----------
    translations : sequence of Translation
        Their reports are changed.
    own : mapping
        The user's own robot file, decoded from JSON, without defaults; ``{"map": …}`` at least.
    refusal : callable
        Returns why a robot file is refused.

    Returns
    -------
    dict
        The robot file, decoded from JSON.
    """
    reports = [report for _, report in translations]
    draft: Draft = {}
    for place, value, source in _winners(translations, own):
        if _finite(value):
            put(draft, place, value)
        else:
            reports[source].withdraw(place, ImportOutcome.REFUSED, f"a number must be finite, not {value}")
    _drop_other_controllers(draft, own, reports)
    return _accepted(draft, own, refusal, reports)


def _winners(translations: Sequence[Translation], own: Mapping[str, Any]) -> Iterator[tuple[str, Any, int]]:
    """Return the places of all drafts that nothing overrides, with their values and the number of their draft."""
    later: dict[str, str] = {place: "the robot file" for place, _ in _leaves(own)}
    winners: list[list[tuple[str, Any, int]]] = []
    for source in reversed(range(len(translations))):
        draft, report = translations[source]
        leaves = dict(_leaves(draft))
        winners.append([])
        for place, value in leaves.items():
            if place in later:
                report.withdraw(place, ImportOutcome.NO_EFFECT, f"{later[place]} sets {place}, and wins")
            else:
                winners[-1].append((place, value, source))
        later |= dict.fromkeys(leaves.keys() - later.keys(), report.source)
    return itertools.chain.from_iterable(reversed(winners))


def _leaves(file: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Return the dotted places and values: fields, and the parameters of each node."""
    for name, value in file.items():
        if name != PARAMETERS or not isinstance(value, Mapping):
            yield name, value
            continue
        for node, table in value.items():
            if isinstance(table, Mapping) and table:
                yield from ((f"{PARAMETERS}.{node}.{each}", given) for each, given in table.items())
            else:
                yield f"{PARAMETERS}.{node}", table


def _finite(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_finite, value))
    if isinstance(value, dict):
        return all(map(_finite, value.values()))
    return not isinstance(value, float) or math.isfinite(value)


def _drop_other_controllers(draft: Draft, own: Mapping[str, Any], reports: Sequence[ImportReport]) -> None:
    """Leave out the parameters of local planners that the robot does not drive with: a clone has only one."""
    file = _merged(draft, own)
    move_base = file.get(PARAMETERS, {}).get("move_base", {})
    used = str(move_base.get(NAME) or file.get(NAME, MoveBaseParameters().base_local_planner))
    for name in [name for name in draft.get(PARAMETERS, {}) if name in CONTROLLERS]:
        if name != CONTROLLERS.own_name(used):
            reason = f"the robot drives with the local planner {used!r}"
            _withdraw(draft, (PARAMETERS, name), ImportOutcome.NO_EFFECT, reason, reports)


def _accepted(draft: Draft, own: Mapping[str, Any], refusal: Refusal, reports: Sequence[ImportReport]) -> Draft:
    """Return the merged file, without those values of the draft that its clone refuses."""
    while True:
        file = _merged(draft, own)
        found = all_faults({name: value for name, value in file.items() if name != MAP}, _within(file, refusal))
        paths = [(tuple(fault.parameter.split("."))[:_NAMED], fault.text) for fault in found]
        refused = [(path, text) for path, text in paths if _has(draft, path)]
        for path, text in refused:
            if _has(draft, path):
                _withdraw(draft, path, ImportOutcome.REFUSED, text, reports)
        if not refused:
            return file


def _within(file: Draft, refusal: Refusal) -> Refusal:
    """Return a check of parts of a file on its map, which is never at fault."""
    of_map = {MAP: file[MAP]} if MAP in file else {}
    return lambda parts: refusal({**parts, **of_map})


def _merged(draft: Draft, own: Mapping[str, Any]) -> Draft:
    mine, theirs = own.get(PARAMETERS, {}), draft.get(PARAMETERS, {})
    if not isinstance(mine, Mapping):
        return {**draft, **own}
    tables = dict(mine)
    for node, table in theirs.items():
        given = mine.get(node, {})
        tables[node] = {**table, **given} if isinstance(given, Mapping) else given
    return {**draft, **own, PARAMETERS: tables}


def _has(draft: Draft, path: tuple[str, ...]) -> bool:
    part: Any = draft
    for step in path:
        if not isinstance(part, Mapping) or step not in part:
            return False
        part = part[step]
    return True


def _withdraw(
    draft: Draft, path: tuple[str, ...], outcome: ImportOutcome, text: str, reports: Sequence[ImportReport]
) -> None:
    """Leave a part out of the draft, and change its entries in the reports."""
    *above, last = path
    part = draft
    for step in above:
        part = part[step]
    del part[last]
    for report in reports:
        report.withdraw(".".join(path), outcome, text)
