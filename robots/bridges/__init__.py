"""Bridges: clients of the cloud for robots that speak other protocols than rosbridge."""
