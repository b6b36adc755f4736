"""Registry of detectors of docks by name."""

from ppaas.docking.detection.base import DockDetector
from ppaas.plugins import PluginRegistry

DOCK_DETECTORS: PluginRegistry[DockDetector] = PluginRegistry(
    "ppaas.dock_detectors",
    "detector of docks",
    DockDetector,  # type: ignore[type-abstract]
    aliases={},
)
