"""Modules that run in processes which the agent's fork server forks, by name: the agent itself must not load them.

So they are imported for type checkers and linters alone, and a name that is wrong here is one that these do not find.
"""

from typing import TYPE_CHECKING

from engine.runtimes.entries import Entries, Entry

if TYPE_CHECKING:
    from engine.agent import layer_jobs  # noqa: F401
    from engine.container import entry  # noqa: F401
    from engine.container.warm_up import freeze, preload, run  # noqa: F401

PRELOAD, WARM_UP, FREEZE = (
    "engine.container.warm_up.preload",
    "engine.container.warm_up.run",
    "engine.container.warm_up.freeze",
)


def loaded_before(function: str, *after: str) -> Entry:
    """Return a function that runs in a container, with what is loaded before: the usual, its module, and then more."""
    return Entry(function, (PRELOAD, function.partition(":")[0], *after), FREEZE)


ENTRIES = Entries(
    container=loaded_before("engine.container.entry:main", WARM_UP),
    maps=loaded_before("engine.agent.layer_jobs:index_here"),
)
