#!/bin/bash
# usage: tests/sanitizers.sh [JOBS]
# The tests under ASan + UBSan, and what has threads under TSan; says how long each took.
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
failed=0
for preset in asan tsan; do
  begun=$SECONDS
  cmake --preset $preset && cmake --build --preset $preset -j "${1:-2}" || exit 1
  built=$SECONDS
  ctest --preset $preset -LE slow || failed=1
  echo "$preset: built in $((built - begun)) s, tested in $((SECONDS - built)) s"
done
exit $failed
