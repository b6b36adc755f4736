"""TODO storage/store_and_forward."""
