"""Plans as stores keep them; below, how they are encoded and when they are used again."""
