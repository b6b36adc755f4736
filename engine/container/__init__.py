"""TODO engine/container."""
