"""TODO storage/memory."""
