"""The REST service under ``/v1``: tools that all routes use, and a package for each group of resources."""
