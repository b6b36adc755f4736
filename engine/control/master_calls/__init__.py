"""Calls between the master and its endpoints: their Protocols, the parts that serve them, registered endpoints."""
