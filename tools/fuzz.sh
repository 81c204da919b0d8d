#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
# Builds the fuzzers of tests/fuzz (preset fuzz) and runs each for so many seconds, two at a time.
#   tools/fuzz.sh SECONDS [NAME…]      names as in tests/fuzz, without _fuzz.cpp; default: all but
#                                      those of app/ (appearance, options, predicates, session),
#                                      whose libraries compile for a quarter of an hour on two cores
# What they find is written to build/fuzz/findings/NAME-crash-…; new inputs stay in
# build/fuzz/corpus. The committed corpora (tests/fuzz/corpus) are made by tools/fuzz_corpus.py.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?expected the seconds for each fuzzer}
shift
names=("$@")
if [ ${#names[@]} -eq 0 ]; then
  names=(sequence ct dicom surface config json mcap buttons igtl ndi usb landmarks)
fi
cmake --preset fuzz -Wno-dev >/dev/null
cmake --build build/fuzz --parallel "$(tools/jobs.sh)" --target "${names[@]/%/_fuzz}"
mkdir -p build/fuzz/findings build/fuzz/logs

one() {
  local name=$1
  mkdir -p "build/fuzz/corpus/$name"
  local silent=0
  if [ "$name" = options ]; then silent=3; fi # It prints help and errors; reports still appear.
  # 25 s and 2 GB: what an input of a few kilobytes may never need.
  if "build/fuzz/tests/fuzz/${name}_fuzz" -max_total_time="$seconds" -timeout=25 -rss_limit_mb=2048 \
    -max_len=65536 -close_fd_mask="$silent" -print_final_stats=1 -artifact_prefix="build/fuzz/findings/$name-" \
    "build/fuzz/corpus/$name" "tests/fuzz/corpus/$name" >"build/fuzz/logs/$name.log" 2>&1; then
    printf '%-10s %s executions, no findings\n' "$name" \
      "$(sed -n 's/^stat::number_of_executed_units: *//p' "build/fuzz/logs/$name.log")"
  else
    printf '%-10s FOUND: %s\n' "$name" "$(grep -m1 -E 'ERROR|runtime error|BUG' "build/fuzz/logs/$name.log")"
    return 1
  fi
}
export -f one
export seconds
printf '%s\n' "${names[@]}" | xargs -P 2 -I{} bash -c 'one {}'
