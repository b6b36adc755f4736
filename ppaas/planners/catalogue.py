"""What is told of the planners that are installed, for people and programs that choose one."""

from dataclasses import asdict, dataclass
from typing import Any

import msgspec

from ppaas.planners.registry import PLANNERS
from ppaas.planners.traits import Traits
from ppaas.plugins import parameters_in_use


@dataclass(frozen=True, slots=True)
class PlannerEntry:
    """One planner.

    Parameters
    ----------
    name : str
        Its own.
    aliases : tuple of str
        Names that ROS has for it, or for one of its kind.
    purpose : str
        When to choose it.
    parameters : dict
        What can be set, and what it is unless said otherwise.
    traits : Traits
    """

    name: str
    aliases: tuple[str, ...]
    purpose: str
    parameters: dict[str, Any]
    traits: Traits


def entry(name: str) -> PlannerEntry:
    """Return what is told of one planner, by its name or an alias.

    Raises
    ------
    NotFound
        No planner of that name is installed; the text lists those there are.
    """
    own, planner = PLANNERS.own_name(name), PLANNERS.create(name, {})
    return PlannerEntry(own, PLANNERS.aliases(own), planner.purpose, parameters_in_use(planner), planner.traits)


def told(planner: PlannerEntry) -> dict[str, Any]:
    """Return an entry as JSON has it; its traits are members of their own."""
    members = asdict(planner) | {"aliases": list(planner.aliases)}
    plain: dict[str, Any] = msgspec.to_builtins(members | members.pop("traits"))
    return plain


def catalogue() -> list[dict[str, Any]]:
    """Return what is told of all planners installed, by name."""
    return [told(entry(name)) for name in PLANNERS.names()]
