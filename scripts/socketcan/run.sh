#!/usr/bin/env bash
# Runs a command under a Linux kernel that has SocketCAN: vcan0 is up, and slcan is there for a serial adapter.
#
#     scripts/socketcan/run.sh COMMAND [ARGUMENT...]
#
# The kernel is Debian's user-mode Linux, an ordinary process: no root, no virtual machine, nothing installed. Once, it is
# fetched (42 MB) into .socketcan/. The command sees this machine's files; what it writes is gone with the kernel.
# Exit status: the command's; 124 where it takes longer than SOCKETCAN_LIMIT_S (300); 125 where there is no such kernel
# to be had or it does not boot, with the reason.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
cache=${SOCKETCAN_CACHE:-$here/../../.socketcan}
root=$cache/root
limit_s=${SOCKETCAN_LIMIT_S:-300}

unable() {
  echo "socketcan: $*" >&2
  exit 125
}

fetch() {
  [ "$(uname -m)" = x86_64 ] || unable "user-mode Linux is for x86_64, and this machine is $(uname -m)"
  for tool in apt-get dpkg gcc; do
    command -v "$tool" >/dev/null || unable "needs $tool (a Debian or Ubuntu with a compiler), which is not here"
  done
  rm -rf "$cache/new" && mkdir -p "$cache/new"
  (cd "$cache/new" && apt-get download user-mode-linux busybox-static >apt.log 2>&1) \
    || unable "apt-get cannot fetch user-mode-linux and busybox-static: $(grep '^E:' "$cache/new/apt.log" | head -1)"
  for package in "$cache"/new/*.deb; do dpkg -x "$package" "$cache/new/root"; done
  gcc -O2 -shared -fPIC -o "$cache/new/root/wide_state.so" "$here/wide_state.c" || unable "gcc cannot compile wide_state.c"
  rm -rf "$root" && mv "$cache/new/root" "$root" && rm -rf "$cache/new"
}

[ $# -gt 0 ] || { echo "socketcan: which command? scripts/socketcan/run.sh COMMAND [ARGUMENT...]" >&2; exit 2; }
[ -e "$root/wide_state.so" ] || fetch
cache=$(cd "$cache" && pwd) root=$cache/root

# Between host and guest: what to run, what it printed, how it ended.
desk=$(mktemp -d)
trap 'rm -rf "$desk"' EXIT
mkdir "$desk/uml"
{
  declare -px PATH HOME VIRTUAL_ENV PYTHONPATH WHEELBENCH_CAPTURES 2>/dev/null || true
  echo ': >/desk/begun'
  printf 'cd %q\n' "$PWD"
  printf '%q ' "$@"
} >"$desk/command"
modules=$root/usr/lib/uml/modules/$(ls "$root/usr/lib/uml/modules")/kernel
for module in fs/overlayfs/overlay net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan drivers/net/can/slcan/slcan
do [ ! -e "$modules/$module.ko" ] || echo "$modules/$module.ko"; done >"$desk/modules"

# It makes a session of its own, out of a terminal's Ctrl-C: whatever ends this script ends all of its processes.
stop() {
  [ ! -s "$desk/kernel" ] || kill -KILL -- "-$(cat "$desk/kernel")" 2>/dev/null || true
  rm -rf "$desk"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

# The guest's memory is a file in TMPDIR. con0 is its output; its last line is not the command's.
shm=/dev/shm
[ -w "$shm" ] || shm=${TMPDIR:-/tmp}
{
  echo "$BASHPID" >"$desk/kernel"
  TMPDIR=$shm LD_PRELOAD=$root/wide_state.so exec "$root/usr/bin/linux.uml" mem="${SOCKETCAN_MEMORY:-1G}" \
    root=/dev/root rootfstype=hostfs rootflags=/ ro init="$here/guest.sh" DESK="$desk" BUSYBOX="$root/bin/busybox" \
    uml_dir="$desk/uml" con=null con0=null,fd:1 ssl=null quiet loglevel=1 </dev/null 2>"$desk/errors"
} | sed -u '/^reboot: System halted/d' &
disown -a
began=$SECONDS
while kill -0 $! 2>/dev/null && [ $((SECONDS - began)) -lt "$limit_s" ]; do sleep 0.1; done
if [ ! -s "$desk/status" ]; then
  [ -e "$desk/begun" ] || unable "the kernel did not boot within $limit_s s: $(tail -n 3 "$desk/errors" | tr '\n' ' ')"
  echo "socketcan: the command was cut off after $((SECONDS - began)) s; SOCKETCAN_LIMIT_S says how long it may take" >&2
  exit 124
fi
exit "$(cat "$desk/status")"
