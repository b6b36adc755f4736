"""Earlier import path of the Move Base client, deprecated: import it from ``robots.client``."""

import warnings

from robots.client.move_base import GoalOutcome, MoveBaseClient

__all__ = ["GoalOutcome", "MoveBaseClient"]

warnings.warn(
    "robots.move_base_client is deprecated: import from robots.client instead, and GoalOutcome from "
    "robots.client.move_base",
    DeprecationWarning,
    stacklevel=2,
)
