"""Registry of the installed runtimes: our own, and third-party ones by entry point."""

from engine.runtimes.base import Runtime
from ppaas.plugins import PluginRegistry

DEFAULT = "process"

RUNTIMES: PluginRegistry[Runtime] = PluginRegistry("ppaas.runtimes", "runtime", Runtime, {})  # type: ignore[type-abstract]
