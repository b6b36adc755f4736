"""TODO engine/specs."""
