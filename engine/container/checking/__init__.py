"""Check of robot files: builds clones as containers do, without running them."""
