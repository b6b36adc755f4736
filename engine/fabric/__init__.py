"""Fabric: the Zenoh session and router of a machine, and the key expressions under which robots share messages."""
