"""Map store in HDFS, over WebHDFS."""
