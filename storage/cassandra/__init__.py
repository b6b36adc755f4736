"""TODO storage/cassandra."""
