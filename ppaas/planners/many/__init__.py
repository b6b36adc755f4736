"""Earlier import path of `plan_many`, deprecated: import it from ``ppaas.planners.batch.plan_many``."""

import warnings

from ppaas.planners.batch.plan_many import plan_many

__all__ = ["plan_many"]

warnings.warn(
    "ppaas.planners.many is deprecated: import from ppaas.planners.batch.plan_many instead",
    DeprecationWarning,
    stacklevel=2,
)
