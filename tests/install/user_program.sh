#!/bin/sh
# usage: user_program.sh CMAKE PREFIX SOURCE_DIR WORK_DIR SANITIZERS HIDDEN_PACKAGES [ARGUMENT...]
# Builds a user's program against what is installed below PREFIX and runs it with the arguments. HIDDEN_PACKAGES: not to
# be found by it, separated by semicolons.
set -eu
cmake=$1 prefix=$2 source=$3 work=$4 sanitize=$5 hidden=$6
shift 6
rm -rf "$work"
[ -z "$sanitize" ] || sanitize=-fsanitize=$sanitize
hide=$(echo "$hidden" | tr ';' '\n' | sed -n 's/..*/-DCMAKE_DISABLE_FIND_PACKAGE_&=ON/p')
# shellcheck disable=SC2086  # one word a package
"$cmake" -S "$source" -B "$work" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS="$sanitize" $hide
"$cmake" --build "$work"
"$work/$(basename "$source")" "$@"
