"""Store of everything but maps in Apache Cassandra."""
