"""Earlier import path of the base controller; new programs import it from ``robots.onboard``."""

from robots.onboard.base_controller import STOP, BaseController, BaseLimits

__all__ = ["STOP", "BaseController", "BaseLimits"]
