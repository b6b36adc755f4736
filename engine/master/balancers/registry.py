"""The balancers that are installed: ours, and other people's by entry point."""

from engine.master.balancer import Balancer
from ppaas.plugins import PluginRegistry

DEFAULT = "ppaas"

BALANCERS: PluginRegistry[Balancer] = PluginRegistry("ppaas.balancers", "balancer", Balancer, {})  # type: ignore[type-abstract]
