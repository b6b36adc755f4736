"""Changes of published maps, which robots that map for life propose as reviewed versions."""
