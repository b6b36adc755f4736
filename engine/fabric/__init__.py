"""Fabric: the Zenoh session and router of a machine, and the key expressions by which robots share messages."""
