"""TODO endpoints/rest/users."""
