#!/bin/sh
# Runs this deck in its own folder. RIPRAP_YADE names another program.
# One thread: with more, two runs of YADE differ in the last digits.
cd "$(dirname "$0")" || exit 1
exec "${RIPRAP_YADE:-yade}" -n -x -j1 run.py "$@"
