"""Messages with paths that are packed as bytes."""
