"""TODO endpoints/rest/maps."""
