"""Memory tuning of the fork server: saves memory, nothing depends on it; ``PPAAS_LEAN=0`` turns it off."""
