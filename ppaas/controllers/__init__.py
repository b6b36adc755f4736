"""Local planners: the interface, the registry and shared parts; each algorithm has a package below."""

from ppaas.controllers.base import Controller, ControlRequest, Velocity, VelocityLimits
from ppaas.controllers.registry import controller_names, create

__all__ = ["ControlRequest", "Controller", "Velocity", "VelocityLimits", "controller_names", "create"]
