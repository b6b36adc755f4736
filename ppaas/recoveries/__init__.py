"""Recovery behaviours: the interface, the registry, one behaviour a file."""

from ppaas.recoveries.base import Recovery, RecoveryFailed, RecoveryRequest
from ppaas.recoveries.registry import create, recovery_names

__all__ = ["Recovery", "RecoveryFailed", "RecoveryRequest", "create", "recovery_names"]
