"""Local planners: the interface, the registry and shared parts; one module for each algorithm."""

from ppaas.controllers.base import Controller, ControlRequest, Velocity, VelocityLimits
from ppaas.controllers.registry import controller_names, create

__all__ = ["ControlRequest", "Controller", "Velocity", "VelocityLimits", "controller_names", "create"]
