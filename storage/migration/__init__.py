"""Migration between stores: copies the records of one to another, and compares the two."""
