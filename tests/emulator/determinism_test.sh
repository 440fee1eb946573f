#!/usr/bin/env bash
# The emulator gives the same events from GCC and clang, with and without optimisation: the hashes of
# emulator_hash.cpp, which change when the pixel model does.
# usage: determinism_test.sh SOURCE_FOLDER WORK_FOLDER COMMAND (emulator_hash as the build made it, with what runs it)
set -euo pipefail

source=$1
work=$2
shift 2
expected="ideal b73cbff1bdc81433
dvs128 c5015911ddc7dd0e
noisy 804d945a12ba579f
davis346 4a3d12ca44cb9eee
atis 7794eb8c27062df9
few_events 2307e6a8b2f97fb0
asymmetric 4fe185480009002b
davis240 4a3d12ca44cb9eee
gen3_vga 30e87776b3549c18
gen4_hd 6fcf582a3a9ca704
everything 22dfbcbae08668b0
measured_noise 9e975a5c61ce9e7d"

status=0
compare() {
  if [[ $2 == "$expected" ]]; then
    echo "$1: as expected"
  else
    printf '%s differs; found:\n%s\nexpected:\n%s\n' "$1" "$2" "$expected"
    status=1
  fi
}

compare "this build" "$("$@")"
mkdir -p "$work"
for file in "$source"/emulator/*.cpp "$source"/core/{config,error,random}.cpp "$source"/threads/*.cpp "$source"/tests/emulator/emulator_hash.cpp; do
  echo "#include \"$file\""  # in one file the headers compile once
done >"$work"/hash.cpp
for way in "g++ -O0" "clang++ -O3"; do
  read -r compiler level <<<"$way"
  if ! command -v "$compiler" >/dev/null; then
    echo "SKIPPED: no $compiler here, its events were not compared"
    continue
  fi
  program=$work/hash_$compiler
  "$compiler" -std=c++20 "$level" -ffp-contract=off -I"$source" "$work"/hash.cpp -pthread -o "$program"
  compare "$way" "$("$program")"
done
exit $status
