"""Documented name of `ppaas.planners.batch.cost_matrix`."""

from ppaas.planners.batch.cost_matrix import cost_matrix

__all__ = ["cost_matrix"]
