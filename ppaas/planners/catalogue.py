"""Catalogue of the installed planners: purpose, parameters and traits of each."""

import logging
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import msgspec

from ppaas.distribution import BrokenPlugin
from ppaas.planners.registry import PLANNERS
from ppaas.planners.traits import Traits
from ppaas.plugins import parameters_in_use

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PlannerEntry:
    """Catalogue entry of one planner.

    Parameters
    ----------
    name : str
        Name of the planner.
    aliases : tuple of str
        Names of the corresponding ROS plug-ins.
    purpose : str
        When to choose it.
    parameters : dict
        Parameters by name, with their default values.
    traits : Traits
        Capabilities.
    """

    name: str
    aliases: tuple[str, ...]
    purpose: str
    parameters: dict[str, Any]
    traits: Traits


def entry(name: str) -> PlannerEntry:
    """Return the entry of one planner, by its name or an alias.

    Raises
    ------
    NotFound
        No planner of that name is installed; the text lists the installed ones.
    """
    own, planner = PLANNERS.own_name(name), PLANNERS.create(name, {})
    return PlannerEntry(own, PLANNERS.aliases(own), planner.purpose, parameters_in_use(planner), planner.traits)


def as_json(planner: PlannerEntry) -> dict[str, Any]:
    """Return an entry as a JSON object, with one member per trait."""
    members = asdict(planner) | {"aliases": list(planner.aliases)}
    plain: dict[str, Any] = msgspec.to_builtins(members | members.pop("traits"))
    return plain


def catalogue(report: Callable[[BrokenPlugin], None] = logger.warning) -> list[dict[str, Any]]:
    """Return the entries of all installed planners as JSON objects, sorted by name.

    Parameters
    ----------
    report : callable
        Called with the error of each planner of another distribution that cannot be loaded, and is left out.
    """
    found = []
    for name in PLANNERS.names():
        try:
            found.append(as_json(entry(name)))
        except BrokenPlugin as error:
            report(error)
    return found
