# Shared by the scripts beside it: where things are, and how a long step is run and reported.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mkdir -p build/logs
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

say() { printf '%s\n' "$@"; }
fail() {
  printf '%s\n' "$*" >&2
  exit 1
}

# A terminal shows the newest line in place; anything else would only fill with noise.
newest_line() {
  if [ ! -t 1 ]; then cat >/dev/null; return; fi
  local line columns
  columns=$(tput cols 2>/dev/null || echo 80)
  while IFS= read -r line; do printf '\r\033[K    %.*s' $((columns - 6)) "${line//$'\t'/ }"; done
  printf '\r\033[K'
}

# step WHAT COMMAND…: say what is done, keep its output in build/logs, show the end of it if it fails.
step() {
  local what=$1 log start=$SECONDS
  shift
  log=build/logs/$(tr -cs '[:alnum:]' '-' <<<"$what" | sed 's/-*$//').log
  printf -- '-- %s\n' "$what"
  if "$@" </dev/null 2>&1 | tee "$log" | newest_line; then
    if ((SECONDS - start >= 2)); then printf -- '   %d s\n' $((SECONDS - start)); fi
  else
    tail -n 40 "$log" >&2
    printf '\n%s: failed. All of its output is in %s\n' "$what" "$PWD/$log" >&2
    return 1
  fi
}
