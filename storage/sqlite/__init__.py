"""TODO storage/sqlite."""
