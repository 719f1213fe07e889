# SocketCAN: Debian's user-mode Linux, which is an ordinary process. Read by run.sh.
limit_s=600  # seven tests in half a minute, and a busy machine may take three minutes for them
needs="gcc"

fetch() {
  download user-mode-linux busybox-static
  for package in "$cache"/new/*.deb; do dpkg -x "$package" "$1"; done
  gcc -O2 -shared -fPIC -o "$1/wide_state.so" "$here/wide_state.c" || unable "gcc cannot compile wide_state.c"
}

boot() {
  local modules=$root/usr/lib/uml/modules/ shm=/dev/shm module
  modules=$modules$(ls "$modules")/kernel
  for module in fs/overlayfs/overlay net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan drivers/net/can/slcan/slcan
  do [ ! -e "$modules/$module.ko" ] || echo "$modules/$module.ko"; done >"$desk/modules"
  mkdir "$desk/uml"
  # The guest's memory is a file in TMPDIR. con0 is its output.
  [ -w "$shm" ] || shm=${TMPDIR:-/tmp}
  TMPDIR=$shm LD_PRELOAD=$root/wide_state.so exec "$root/usr/bin/linux.uml" mem="$memory" \
    root=/dev/root rootfstype=hostfs rootflags=/ ro init="$here/guest.sh" BUSYBOX="$root/bin/busybox" \
    MODULES="$desk/modules" DESK="$desk" DESK_TYPE=hostfs DESK_OPTIONS="$desk" \
    uml_dir="$desk/uml" con=null con0=null,fd:1 ssl=null quiet loglevel=1
}
