"""Files of other programs, read into the project's own forms with a report of each part."""
