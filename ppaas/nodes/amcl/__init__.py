"""Node ``amcl``: adaptive Monte Carlo localization in the map."""
