"""REST resources of maps: upload and its checks, versions, and the cells of a grid."""
