# Skips a case (77) where a solver is missing.
for solver in liggghts yade; do
  if ! command -v "$solver" >/dev/null; then
    echo "skipped: $solver is not installed"
    exit 77
  fi
done
