"""Parts: what becomes of a map whose robot was carried away. Parts that nothing connects join where they overlap."""
