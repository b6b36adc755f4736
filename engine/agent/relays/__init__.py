"""Relays of a machine: they connect its containers with the master and with endpoints that these cannot dial."""
