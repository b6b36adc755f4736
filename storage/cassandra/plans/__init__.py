"""TODO storage/cassandra/plans."""
