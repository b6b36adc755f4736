"""Cost fields: the cost-to-go of each cell of a map, grown from its goals."""
