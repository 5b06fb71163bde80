#!/bin/bash
# Runs a recorder on topics whose names may begin with @, the namespace: topics have their full names in a bag.
# Adds those of the scene's sensors, whose names only the scene knows. An earlier bag of the name is kept: the new one gets
# a number. At the end says what the bag lacks. Usage: record.sh RECORDER -O BAG TOPIC …
namespace=${ROS_NAMESPACE%/}
recorder=$1 wanted=${3%.bag}
shift 3
set -- "${@/#@/$namespace/}"
for sensor in $(PATH=/usr/bin:$PATH rosparam get "$namespace/planar_chain/sensors" 2>/dev/null | sed -n "s/^'\?\([A-Za-z][A-Za-z0-9_]*\)'\?:.*/\1/p"); do
  set -- "$@" "$namespace/planar_chain/$sensor"
done
bag=$wanted
for ((k = 2; ; k++)); do
  [[ -e $bag.bag || -e $bag.bag.active ]] || break
  bag=${wanted}_$k
done
[ "$bag" = "$wanted" ] || echo "record: $wanted.bag is there already; recording to $bag.bag"
trap : INT TERM  # ends the recorder, which is of the same process group; the check comes after it
"$recorder" -O "$bag" "$@" || status=$?
[ -z "${status:-}" ] || echo "record: the recorder failed with status $status, so $bag.bag is not complete, and the launch ends" >&2
[ ! -e "$bag.bag" ] || PATH=/usr/bin:$PATH python3 "$(dirname "$0")/recorded" "$bag.bag" || status=$?
exit "${status:-0}"
