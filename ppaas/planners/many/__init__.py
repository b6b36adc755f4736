"""Documented name of `ppaas.planners.batch.plan_many`."""

from ppaas.planners.batch.plan_many import plan_many

__all__ = ["plan_many"]
