"""How many examples a property tries in one run: ``PPAAS_PROPERTY_EXAMPLES`` is the number for ordinary properties.

Each run tries other examples, so many short runs try more than a long one: ``make unit`` tries ten of each,
``make test`` thirty, ``make properties`` a thousand.
"""

import os

ORDINARY = 30
"""Number of examples that ``make test`` tries of most properties."""

EXAMPLES = int(os.environ.get("PPAAS_PROPERTY_EXAMPLES", ORDINARY))


def examples(usual: int) -> int:
    """Return the number for a property whose examples are dear or many, of which ``make test`` tries so many."""
    return max(1, usual * EXAMPLES // ORDINARY)
