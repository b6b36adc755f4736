"""Pictures as PNG: paths on maps, changes of maps, and charts."""
