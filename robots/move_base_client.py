"""Earlier import path of the Move Base client; new programs import it from ``robots.client``."""

from robots.client.move_base import GoalOutcome, MoveBaseClient

__all__ = ["GoalOutcome", "MoveBaseClient"]
