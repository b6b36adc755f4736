"""TODO endpoints/http."""
