"""Alias of ``robots.onboard``, for programs that import the base controller by its earlier path."""

from robots.onboard.base_controller import STOP, BaseController, BaseLimits

__all__ = ["STOP", "BaseController", "BaseLimits"]
