"""REST resources of users and their tokens."""
