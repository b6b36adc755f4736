"""Stores in the memory of one process, for tests and for clouds without persistent data."""
