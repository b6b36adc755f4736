"""TODO endpoints/services."""
