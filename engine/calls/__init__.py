"""Calls between processes: methods of an interface, called over a link in both directions."""
