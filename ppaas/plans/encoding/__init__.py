"""Encoding of plans for stores: waypoints as bytes, and the keys by which plans are found."""
