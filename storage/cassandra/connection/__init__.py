"""TODO storage/cassandra/connection."""
