"""Planning on a map file without a cloud. Needs the extra ``plan``."""
