"""Leadership: one process of a cloud at a time is its master, by a lease in the store."""
