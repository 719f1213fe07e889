#!/bin/sh
# The first process of the kernel that run.sh starts. With the kernel's command line come BUSYBOX, MODULES (a list of
# them, in order), how the desk is mounted, and HOST, which is empty where the root file system is the host's already.
# The host's files are read-only: everything happens on a copy in memory over them.
exec "$BUSYBOX" sh -c '
b=$BUSYBOX
$b mount -t proc proc /proc && $b mount -t sysfs sysfs /sys
while read -r module; do $b insmod "$module"; done <"$MODULES"
[ -z "$HOST" ] || $b mount -t 9p -o "ro,$HOST_OPTIONS" host "$HOST"
$b mount -t tmpfs memory /mnt && $b mkdir /mnt/upper /mnt/work /mnt/root
new=/mnt/root
$b mount -t overlay -o lowerdir="${HOST:-/}",upperdir=/mnt/upper,workdir=/mnt/work overlay $new || $b poweroff -f
$b mount -t proc proc $new/proc && $b mount -t sysfs sysfs $new/sys && $b mount -t devtmpfs dev $new/dev
$b mkdir -p $new/dev/pts $new/dev/shm $new/desk
$b mount -t devpts devpts $new/dev/pts
$b mount -t tmpfs shm $new/dev/shm
$b mount -t "$DESK_TYPE" -o "$DESK_OPTIONS" desk $new/desk
$b ip link set lo up
[ ! -d /sys/module/vcan ] || { $b ip link add vcan0 type vcan && $b ip link set vcan0 up; }
# Standard error goes where standard output does: the console is the only way out.
$b chroot $new /bin/bash -c ". /desk/command; echo \$? >/desk/status" 2>&1
$b sync
$b poweroff -f
'
