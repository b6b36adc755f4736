"""People whom robots see: their settings, and the store of hourly counts."""
