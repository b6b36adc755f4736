"""TODO engine/protocols."""
