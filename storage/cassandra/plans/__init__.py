"""The Path Plan Database in Cassandra: plans, the entries they share, and spatial indexes to find them by."""
