"""Registry of the installed balancers: the built-in ones, and other distributions', by entry point."""

from engine.master.balancer import Balancer
from ppaas.plugins import PluginRegistry

DEFAULT = "ppaas"

BALANCERS: PluginRegistry[Balancer] = PluginRegistry("ppaas.balancers", "balancer", Balancer, {})  # type: ignore[type-abstract]
