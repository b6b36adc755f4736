"""Recovery behaviours: the interface, the registry, and one module per behaviour."""

from ppaas.recoveries.base import Recovery, RecoveryFailed, RecoveryRequest
from ppaas.recoveries.registry import create, recovery_names

__all__ = ["Recovery", "RecoveryFailed", "RecoveryRequest", "create", "recovery_names"]
