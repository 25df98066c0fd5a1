#!/bin/sh
# usage: headers_compile_alone.sh ROOT COMPILER FLAGS...
# Compiles every header of ours below ROOT by itself, names those that need another one first, and fails if any does.
set -u
root=$1
shift
cd "$root" || exit 1

check_one='
header=$1
shift
if ! errors=$("$@" -I. -fsyntax-only -x c++ -include "$header" /dev/null 2>&1); then
  echo "does not compile alone: $header"
  echo "$errors" | head -n 20
  exit 1
fi'
headers=$(find calibration perception servo app tests -name "*.hpp" -not -path "*/broken_house/*" 2>/dev/null | sort)
[ -n "$headers" ] || { echo "no headers below $root"; exit 1; }
echo "$headers" | xargs -P "$(nproc)" -I HEADER sh -c "$check_one" check HEADER "$@"
