"""TODO engine/processes."""
