"""Earlier import path of the base controller, deprecated: import it from ``robots.onboard``."""

import warnings

from robots.onboard.base_controller import STOP, BaseController, BaseLimits

__all__ = ["STOP", "BaseController", "BaseLimits"]

warnings.warn(
    "robots.base_controller is deprecated: import from robots.onboard instead, and STOP from "
    "robots.onboard.base_controller",
    DeprecationWarning,
    stacklevel=2,
)
