"""TODO endpoints/rest/robots."""
