#!/bin/sh
# usage: links_stay_light.sh FORBIDDEN LIBRARY...
# No library may need one whose file name matches the regular expression FORBIDDEN. Only what it names itself counts:
# what OpenCV's core brings along is OpenCV's affair.
set -u
forbidden=$1 bad=0
shift
for library in "$@"; do
  needed=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p')
  [ -n "$needed" ] || needed=forbidden-for-it-cannot-be-read
  for name in $(echo "$needed" | grep -E "$forbidden|cannot-be-read"); do
    echo "$(basename "$library") needs $name"
    bad=$((bad + 1))
  done
done
echo "$bad links too many"
[ "$bad" -eq 0 ]
