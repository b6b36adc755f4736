"""TODO endpoints/accounts."""
