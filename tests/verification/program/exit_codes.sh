#!/usr/bin/env bash
# What dccast-verify tells a script: its exit codes, and the keys of its JSON.
set -euo pipefail
verify=$1

expect() { # exit code, then the command
  local wanted=$1 code=0
  shift
  "$verify" "$@" >out.txt 2>err.txt || code=$?
  [ "$code" -eq "$wanted" ] && return
  echo "dccast-verify $*: exit code $code, not $wanted" >&2
  cat err.txt >&2
  exit 1
}

cd "$(mktemp -d)"
trap 'rm -rf "$PWD"' EXIT

expect 0 list
expect 0 run T4 --dt 0.0625 --json
for key in displacement_error stress_error iterations_per_step cpu_s elements nodes steps; do
  grep -q "\"$key\"" out.txt || { echo "no $key in the JSON of run" >&2; exit 1; }
done
expect 0 run stefan --json # no displacement there, but the key is
grep -q '"displacement_error": null' out.txt

expect 3 run T4 --algorithm nbm --plain --dt 0.0625
grep -q 't = 0.3125 s' err.txt

expect 2 run no-such-test
expect 2 run T4 --dt -1
expect 2 table 9

echo '{"code": "mine", "version": "1", "predictions": []}' >mine.json
expect 1 record mine.json
grep -q 'seal a prediction before it is compared' err.txt

# A build of the core alone has no castings.
if "$verify" history --help | grep -q divide-steps; then
  expect 0 history --quality draft -o curl.csv
  head -n 1 curl.csv | grep -qx 'time_s,curl_mm'
  tail -n 1 curl.csv | grep -q '^145,5\.'
  expect 3 history --quality draft --limit 0.001
  expect 2 history --quality coarse
fi

cat >strand.json <<'JSON'
{"conductivity_w_per_m_k": 180, "speed_m_per_s": 0.001, "length_m": 0.15,
 "top_temperature_c": 680, "bottom_temperature_c": 100,
 "temperature_c": [0, 620, 649, 700], "enthalpy_j_per_m3": [0, 1.674e9, 2.746e9, 2.874e9]}
JSON
expect 0 run strand --data strand.json --json
sed -i 's/680/900/' strand.json # hotter than its table knows
expect 2 run strand --data strand.json
grep -q 'strand.json' err.txt
