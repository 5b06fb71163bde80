#!/bin/bash
# Runs a recorder on topics whose names may begin with @, the namespace: topics have their full names in a bag.
# Adds those of the scene's sensors, whose names only the scene knows. Usage: record.sh RECORDER ARGUMENT …
namespace=${ROS_NAMESPACE%/}
recorder=$1
shift
set -- "${@/#@/$namespace/}"
for sensor in $(PATH=/usr/bin:$PATH rosparam get "$namespace/planar_chain/sensors" 2>/dev/null | sed -n 's/^\([A-Za-z][A-Za-z0-9_]*\):.*/\1/p'); do
  set -- "$@" "$namespace/planar_chain/$sensor"
done
exec "$recorder" "$@"
