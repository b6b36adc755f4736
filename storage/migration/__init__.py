"""TODO storage/migration."""
