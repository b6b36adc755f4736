#!/bin/sh
# Runs one daemon of HDFS: `run.sh namenode`, which makes an empty file system the first time, or `run.sh datanode`.
set -eu
PACKAGE=org.apache.hadoop.hdfs.server

case "$1" in
  namenode)
    [ -d /var/lib/hdfs/name/current ] || java @/opt/hdfs/java.options "$PACKAGE.namenode.NameNode" -format -nonInteractive
    exec java @/opt/hdfs/java.options "$PACKAGE.namenode.NameNode" ;;
  datanode)
    exec java @/opt/hdfs/java.options "$PACKAGE.datanode.DataNode" ;;
  *)
    echo "say namenode or datanode, not $1" >&2; exit 2 ;;
esac
