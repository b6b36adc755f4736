"""TODO storage/files."""
