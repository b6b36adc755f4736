"""Parts of all imports of maps: their result and options, and free space within walls."""
