"""Command for buildings, and the import of buildings of other programs."""
