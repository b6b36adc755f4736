"""Connection to a Cassandra cluster: its address, the schema of the keyspace, and the errors of the driver."""
