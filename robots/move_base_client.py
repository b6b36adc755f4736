"""Alias of ``robots.client``, for programs that import the Move Base client by its earlier path."""

from robots.client.move_base import GoalOutcome, MoveBaseClient

__all__ = ["GoalOutcome", "MoveBaseClient"]
