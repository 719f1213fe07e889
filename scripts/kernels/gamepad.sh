# uinput, joydev and evdev: Debian's own kernel in QEMU's software emulation. Read by run.sh.
# Debian's user-mode Linux and its cloud kernel are built without uinput and joydev.
limit_s=1800
needs="tar setsid"

modules="virtio_ring virtio virtio_pci_legacy_dev virtio_pci_modern_dev virtio_pci netfs fscache 9pnet 9pnet_virtio 9p
  overlay evdev joydev uinput"

fetch() {
  local kernel package
  # Of QEMU and what it depends on, whatever this machine has not. linux-image-amd64 itself is empty: it names the newest.
  local packages=(busybox-static)
  kernel=$(apt-cache depends linux-image-amd64 2>/dev/null | awk '/Depends: linux-image-/ {print $2; exit}')
  packages+=("${kernel:-linux-image-amd64}")
  command -v qemu-system-x86_64 >/dev/null || mapfile -t -O 2 packages < <(
    apt-get install --simulate --no-install-recommends qemu-system-x86 2>/dev/null | awk '/^Inst/ {print $2}')
  download "${packages[@]}"
  mkdir "$1/kernel"
  for package in "$cache"/new/*.deb; do
    if [[ $package != */linux-image-* ]]; then
      dpkg -x "$package" "$1"
      continue
    fi
    # Of 400 MB, what is needed.
    # shellcheck disable=SC2046
    dpkg --fsys-tarfile "$package" | tar -x -C "$1/kernel" --transform 's|.*/||' --wildcards './boot/vmlinuz-*' \
      $(printf './lib/modules/*/%s.ko ' $modules) || unable "${package##*/} has not the modules that this takes"
  done
  [ -n "$(qemu "$1")" ] || unable "apt-get does not know how to install qemu-system-x86"
}

qemu() {
  if [ -x "$1/usr/bin/qemu-system-x86_64" ]; then echo "$1/usr/bin/qemu-system-x86_64"; else command -v qemu-system-x86_64; fi
}

# The first file system, in memory: busybox, the modules in the order in which they go in, and guest.sh.
first_files() {
  local files=$desk/files module
  mkdir -p "$files/bin" "$files/modules" "$files/proc" "$files/sys" "$files/mnt" "$files/host"
  cp "$root/bin/busybox" "$files/bin/busybox" && ln -s busybox "$files/bin/sh" && cp "$here/guest.sh" "$files/init"
  for module in $modules; do
    cp "$root/kernel/$module.ko" "$files/modules" && echo "/modules/$module.ko"
  done >"$files/modules/list"
  (cd "$files" && find . | "$root/bin/busybox" cpio -o -H newc 2>/dev/null) >"$desk/first" && rm -r "$files"
}

boot() {
  local lib=usr/lib/x86_64-linux-gnu nine=trans=virtio,version=9p2000.L,msize=512000 share
  first_files
  LD_LIBRARY_PATH=$root/$lib:$root/lib/x86_64-linux-gnu QEMU_MODULE_DIR=$root/$lib/qemu exec setsid "$(qemu "$root")" \
    $(for share in "$root"/usr/share/{qemu,seabios} /usr/share/{qemu,seabios}; do printf -- '-L %q ' "$share"; done) \
    -nodefaults -no-user-config -machine q35 -accel tcg -cpu max -m "$memory" -display none -serial stdio -no-reboot \
    -kernel "$root"/kernel/vmlinuz-* -initrd "$desk/first" \
    -append "console=ttyS0 quiet loglevel=1 panic=-1 mitigations=off nokaslr BUSYBOX=/bin/busybox MODULES=/modules/list \
HOST=/host HOST_OPTIONS=$nine,cache=loose DESK_TYPE=9p DESK_OPTIONS=$nine" \
    -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap \
    -virtfs "local,path=$desk,mount_tag=desk,security_model=none"
}
