"""Leases in memory."""

import threading

from storage.names import check_name
from storage.records import Lease, check_lease


class MemoryLeases:
    """A ``LeaseStore`` of a dictionary."""

    def __init__(self) -> None:
        self._lease_lock = threading.Lock()
        self._leases: dict[str, Lease] = {}

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        check_name("lease", name)
        with self._lease_lock:
            return self._leases.get(name, Lease(name))

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was."""
        check_lease(lease, instead_of)
        with self._lease_lock:
            if self._leases.get(lease.name, Lease(lease.name)) != instead_of:
                return False
            self._leases[lease.name] = lease
            return True
