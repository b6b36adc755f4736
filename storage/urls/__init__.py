"""TODO storage/urls."""
