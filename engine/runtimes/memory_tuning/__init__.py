"""Memory tuning of the fork server. It only saves memory; ``PPAAS_LEAN=0`` turns it off."""
