# What the tests of the command line share; sourced by tests/test_cli*.sh, with the program as $1.
# They run in a scratch folder, $work, and end with `summary`.
set -u
export LC_ALL=C TERM=xterm
program=$(realpath "${1:?usage: $0 PROGRAM}")
scripts=$(realpath "$(dirname "$0")/../scripts")
export PYTHONPATH=$(realpath "$(dirname "$0")") PYTHONDONTWRITEBYTECODE=1 # of what tests share
work=$(mktemp -d)
mounted=
passed=0 failed=0 skipped=0

finish() {
  [ -z "$mounted" ] || umount "$mounted"
  rm -rf "$work"
}
trap finish EXIT
cd "$work" || exit 1

# ---- checks ------------------------------------------------------------------------------------

pass() { passed=$((passed + 1)); }
fail() { failed=$((failed + 1)); echo "FAIL $*"; }
skip() { skipped=$((skipped + 1)); echo "skip $*"; }

# check NAME COMMAND...: the command succeeds.
check() {
  local name=$1
  shift
  if "$@" >/dev/null 2>&1; then pass; else fail "$name: $*"; fi
}

# with_library COMMAND...: a program that loads libhetab.so itself. Under AddressSanitizer its runtime has to be there
# first, and such programs leave the freeing to their end.
with_library() {
  if [ -n "${ASAN_OPTIONS:-}" ]; then
    LD_PRELOAD=$(cc -print-file-name=libasan.so) ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0 "$@"
  else
    "$@"
  fi
}

# works NAME ARGUMENT...: hetab succeeds and says nothing on standard error; its output is in ./out.
works() {
  local name=$1 status
  shift
  "$program" "$@" >out 2>err </dev/null
  status=$?
  if [ $status = 0 ] && [ ! -s err ]; then pass; else fail "$name: status $status, $(head -c 300 err)"; fi
}

# refuses NAME STATUS PATTERN ARGUMENT...: hetab fails with one line that matches, and prints nothing
# else. Standard input is ./in.
refuses() {
  local name=$1 expected=$2 pattern=$3 status
  shift 3
  "$program" "$@" >out 2>err <in
  status=$?
  one_line "$name" "$status" "$expected" "$pattern"
}

# one_line NAME STATUS EXPECTED PATTERN: on ./err.
one_line() {
  if [ "$2" != "$3" ]; then
    fail "$1: status $2 instead of $3, $(head -c 300 err)"
  elif [ "$(wc -l <err)" != 1 ] || ! grep -q '^hetab: ' err || ! grep -Eq -- "$4" err; then
    fail "$1: message $(head -c 300 err)"
  else
    pass
  fi
}

has() { grep -Eq -- "$1" out; }
json() { /usr/bin/python3 -c "import json, sys; d = json.load(open('out')); sys.exit(not ($1))"; }
: >in

# The counts, and the status of the whole.
summary() {
  echo "$passed passed, $failed failed, $skipped skipped"
  [ $failed = 0 ]
}
