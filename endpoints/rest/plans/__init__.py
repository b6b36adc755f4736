"""TODO endpoints/rest/plans."""
