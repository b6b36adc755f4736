"""The path plan database in Cassandra: plans, the entries that they share, and spatial indexes."""
