"""Store of everything but maps in one SQLite file."""
