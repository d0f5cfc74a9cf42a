#!/usr/bin/env bash
# Writes tests/verification/RESULTS.md anew: every figure and table with the command that made it.
#   tests/verification/write_tables.sh build/release/bin/dccast-verify > tests/verification/RESULTS.md
# Takes some eight minutes of one core; a quarter of an hour more with DCCAST_FULL=1, the paper's time steps in tables 4
# to 6, and as much again with DCCAST_NIGHTLY=1, the figures that take minutes. TABLE_11_LIMIT bounds the seconds of each
# algorithm of table 11.
set -euo pipefail
verify=$1
export OPENBLAS_NUM_THREADS=1

show() { # the command as a reader would type it, then what it prints
  echo
  echo "\`dccast-verify $*\`"
  echo
  "$verify" "$@" 2>/dev/null || echo "(exit code $?)"
}

cat <<'TEXT'
# Verification: figures and tables

Written by `tests/verification/write_tables.sh`; nothing in it is typed by hand. What each test is,
with its source, stands in [README](README.md). Errors are relative,
seconds are processor time of one core. "u" is displacement, "s" stress.

`dccast-verify report -o FILE.html` writes the same as one page with plots.

## Every claimed figure
TEXT
full=() nightly=()
[ "${DCCAST_FULL:-0}" = 1 ] && full=(--full)
[ "${DCCAST_NIGHTLY:-0}" = 1 ] && nightly=(--nightly)
show all "${nightly[@]}"
echo
echo "## Tables of the paper beside ours"
for number in 1 2 3; do show table "$number"; done
cat <<'TEXT'

Shear stress of T1 at epsilon = 1e-3, the paper's figures 9 to 11
(`dccast-verify shear --delta D --beta B -o FILE`):

![delta 1, beta 2](t1-shear-delta1-beta2.svg)
![delta 1, beta 1](t1-shear-delta1-beta1.svg)
![delta 2, beta 1](t1-shear-delta2-beta1.svg)
TEXT
for number in 4 5 6; do show table "$number" "${full[@]}"; done
echo
echo "Table 7 has the rows of SBM and NBM of table 8."
show table 8
show table 11 --limit "${TABLE_11_LIMIT:-1800}"
show table 11 --slab --limit "${TABLE_11_SLAB_LIMIT:-60}"
echo
echo "## Element families under refinement"
show elements
