"""Earlier import path of `cost_matrix`, deprecated: import it from ``ppaas.planners.batch.cost_matrix``."""

import warnings

from ppaas.planners.batch.cost_matrix import cost_matrix

__all__ = ["cost_matrix"]

warnings.warn(
    "ppaas.planners.cost_matrix is deprecated: import from ppaas.planners.batch.cost_matrix instead",
    DeprecationWarning,
    stacklevel=2,
)
