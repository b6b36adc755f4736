"""Clients of places within this process, through which endpoints of other protocols reach clones."""
