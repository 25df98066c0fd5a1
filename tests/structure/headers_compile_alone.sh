#!/bin/sh
# usage: headers_compile_alone.sh ROOT CACHE COMPILER FLAGS...
# Compiles every header of the product below ROOT by itself, names those that need another one first, and fails if any does.
# One that is the first include of a source is left out: the build itself compiles it alone.
# CACHE keeps, for each header that passed, the list of files it includes: until one of them is newer, it need not be
# compiled again.
set -u
root=$1 cache=$2
shift 2
mkdir -p "$cache" && cd "$root" || exit 1
[ -e "$cache/empty.cpp" ] || : >"$cache/empty.cpp"

check_one='
header=$1 empty=$2/empty.cpp passed=$2/$(echo "$1" | tr / _).d
shift 2
if [ -e "$passed" ]; then
  newer=$(sed "s/^[^:]*://; s/\\\\$//" "$passed" | tr -s " " "\n" |
    grep . | xargs -I FILE find FILE -prune -newer "$passed" 2>&1)
  [ -n "$newer" ] || exit 0
  rm -f "$passed"
fi
if errors=$("$@" -I. -fsyntax-only -MMD -MF "$passed.new" -include "$header" "$empty" 2>&1); then
  mv "$passed.new" "$passed"
else
  rm -f "$passed.new"
  echo "does not compile alone: $header"
  echo "$errors" | head -n 20
  exit 1
fi'
ours() { find calibration perception servo app tests -name "$1" -not -path "*/broken_house/*" 2>/dev/null | sort; }
ours "*.cpp" | xargs grep -hm1 '^#include' /dev/null | sed -n 's/^#include "\(.*\)"$/\1/p' | sort -u >"$cache/first_includes"
headers=$(ours "*.hpp" | grep -v "^tests/" | grep -vxFf "$cache/first_includes")
[ -n "$headers" ] || { echo "no headers below $root"; exit 1; }
echo "$headers" | xargs -P "$(nproc)" -I HEADER sh -c "$check_one" check HEADER "$cache" "$@"
