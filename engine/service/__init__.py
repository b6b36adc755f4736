"""TODO engine/service."""
