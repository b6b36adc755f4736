"""TODO engine/master."""
