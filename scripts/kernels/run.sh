#!/usr/bin/env bash
# Runs a command under a Linux kernel that has what this machine's may lack.
#
#     scripts/kernels/run.sh socketcan COMMAND [ARGUMENT...]    SocketCAN: vcan0 is up, slcan is there for a serial adapter
#     scripts/kernels/run.sh gamepad COMMAND [ARGUMENT...]      uinput, joydev and evdev: /dev/uinput makes gamepads
#
# No root, nothing installed: the kernel is Debian's, an ordinary process, as socketcan.sh and gamepad.sh beside this
# file say. What it takes is fetched once, into a folder of that name with a dot before it. The command sees this
# machine's files; what it writes is gone with the kernel.
# Exit status: the command's; 124 where it takes longer than KERNEL_LIMIT_S; 125 where there is no such kernel to be had
# or it does not boot, with the reason.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
kind=${1:-}
[ $# -gt 1 ] && [ -e "$here/$kind.sh" ] && [ "$kind" != run ] && [ "$kind" != guest ] || {
  echo "kernels: which kernel, which command? scripts/kernels/run.sh socketcan|gamepad COMMAND [ARGUMENT...]" >&2
  exit 2
}
shift
cache=${KERNEL_CACHE:-$here/../../.$kind}
root=$cache/root
memory=${KERNEL_MEMORY:-1G}

unable() {
  echo "$kind: $*" >&2
  exit 125
}

# download PACKAGE...: into the folder that becomes the cache when all of it is there.
download() {
  (cd "$cache/new" && apt-get download "$@" >apt.log 2>&1) || unable "apt-get cannot fetch what it takes: $(
    grep '^E:' "$cache/new/apt.log" | head -1)"
}

# What differs: how long a command may take, which tools fetching needs, fetch, and boot, which becomes the kernel.
# shellcheck source=/dev/null
. "$here/$kind.sh"
limit_s=${KERNEL_LIMIT_S:-$limit_s}

if [ ! -e "$root/fetched" ]; then
  [ "$(uname -m)" = x86_64 ] || unable "the kernel is one for x86_64, and this machine is $(uname -m)"
  for tool in apt-get dpkg $needs; do
    command -v "$tool" >/dev/null || unable "needs $tool (as a Debian or Ubuntu has it), which is not here"
  done
  rm -rf "$cache/new" && mkdir -p "$cache/new/root"
  fetch "$cache/new/root"
  touch "$cache/new/root/fetched"
  rm -rf "$root" && mv "$cache/new/root" "$root" && rm -rf "$cache/new"
fi
cache=$(cd "$cache" && pwd) root=$cache/root

# Between host and guest: what to run, what it printed, how it ended.
desk=$(mktemp -d)
trap 'rm -rf "$desk"' EXIT
{
  declare -px PATH HOME VIRTUAL_ENV PYTHONPATH WHEELBENCH_CAPTURES 2>/dev/null || true
  echo ': >/desk/begun'
  printf 'cd %q\n' "$PWD"
  printf '%q ' "$@"
} >"$desk/command"

# It makes a session of its own, out of a terminal's Ctrl-C: whatever ends this script ends all of its processes.
stop() {
  [ ! -s "$desk/kernel" ] || kill -KILL -- "-$(cat "$desk/kernel")" 2>/dev/null || true
  rm -rf "$desk"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

# The console is the command's output; its last line is the kernel's. A serial one ends lines as a teletype did.
{
  echo "$BASHPID" >"$desk/kernel"
  boot </dev/null 2>"$desk/errors"
} | sed -u 's/\r$//; /reboot: \(System halted\|Power down\)/d' &
disown -a
began=$SECONDS
while kill -0 $! 2>/dev/null && [ $((SECONDS - began)) -lt "$limit_s" ]; do sleep 0.1; done
if [ ! -s "$desk/status" ]; then
  [ -e "$desk/begun" ] || unable "the kernel did not boot within $((SECONDS - began)) s: $(tail -n 3 "$desk/errors" | tr '\n' ' ')"
  echo "$kind: the command was cut off after $((SECONDS - began)) s; KERNEL_LIMIT_S says how long it may take" >&2
  exit 124
fi
exit "$(cat "$desk/status")"
