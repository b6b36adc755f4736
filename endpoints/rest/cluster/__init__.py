"""TODO endpoints/rest/cluster."""
