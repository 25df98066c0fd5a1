#!/bin/sh
# usage: install_test.sh CMAKE BUILD_DIR USER_PROGRAM WORK_DIR SANITIZERS
set -eu
cmake=$1 build=$2 user=$3 work=$4 sanitize=$5
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" >"$work.log" 2>&1 || { cat "$work.log"; exit 1; }

set -- -S "$user" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix"
for hidden in VISP Ceres yaml-cpp fmt spdlog CLI11 nlohmann_json TBB OpenSSL; do
  set -- "$@" -DCMAKE_DISABLE_FIND_PACKAGE_$hidden=ON
done
[ -z "$sanitize" ] || set -- "$@" -DCMAKE_CXX_FLAGS="-fsanitize=$sanitize"
"$cmake" "$@"
"$cmake" --build "$work/build"

# A ball of 70 mm at 1 m before a camera of f = 500 px: 500 * 0.035 / sqrt(1 - 0.035^2) = 17.51 px.
answer=$("$work/build/user_program")
echo "$answer"
[ "$answer" = "radius 17.51 px, a ball at 1.000 m" ] || { echo "unexpected answer of the user's program"; exit 1; }

version=$("$work/prefix/bin/ballservo" --version)
case $version in
  "ballservo "[0-9]*) echo "$version" ;;
  *) echo "the installed program does not run: $version"; exit 1 ;;
esac
