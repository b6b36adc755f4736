"""Names of the modules that run in the fork server's children: the agent itself must not load them.

Type checkers and linters see them as imports, and report a module that does not exist.
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
    """Return the entry of a function, preceded by the common preload, the function's module, and ``after``."""
    return Entry(function, (PRELOAD, function.partition(":")[0], *after), FREEZE)


ENTRIES = Entries(
    container=loaded_before("engine.container.entry:main", WARM_UP),
    maps=loaded_before("engine.agent.layer_jobs:index_here"),
)
