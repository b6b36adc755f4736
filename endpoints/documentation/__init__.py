"""Documentation site that a cloud serves, where it is built."""
