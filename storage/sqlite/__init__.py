"""Store of everything but maps in an SQLite file."""
