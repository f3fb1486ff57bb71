#!/usr/bin/env bash
# Fuzzes the reader of commands with libFuzzer, address and undefined-behaviour sanitizers, from the fixed corpus on. What it finds
# beyond that goes into build/fuzz/corpus, a crash into build/fuzz; a crash's input belongs into tests/fuzz/corpus with its fix.
#   tests/fuzz/run.sh [RUNS]      default: 1000000
set -euo pipefail
cd "$(dirname "$0")/../.."
RUNS=${1:-1000000}
OUT=build/fuzz
mkdir -p "$OUT/corpus"

CLANG=$(command -v clang++ || command -v clang++-14 || true)
if [ -z "$CLANG" ]; then
  apt-get update -q
  DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends clang libclang-rt-14-dev
  CLANG=clang++
fi
"$CLANG" -std=c++20 -O1 -g -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined -Ifsw -I. -isystem /usr/include/eigen3 \
  -o "$OUT/commands" tests/fuzz/command_target.cpp fsw/bus/{commands,events,fields,layout,packet_table,telemetry}.cpp fsw/base/{assert,crc}.cpp
"$OUT/commands" -runs="$RUNS" -seed=1 -max_len=1401 -print_final_stats=1 -artifact_prefix="$OUT/" "$OUT/corpus" tests/fuzz/corpus
