"""Requests of containers to the stores, which their machine executes for them."""
