#!/bin/sh
# The first process of the kernel that run.sh starts. DESK and BUSYBOX come with the kernel's command line.
# The root file system is the host's, read-only: everything happens on a copy in memory over it.
exec "$BUSYBOX" sh -c '
b=$BUSYBOX
$b mount -t proc proc /proc && $b mount -t sysfs sysfs /sys
while read -r module; do $b insmod "$module"; done <"$DESK/modules"
$b mount -t tmpfs memory /mnt && $b mkdir /mnt/upper /mnt/work /mnt/root
new=/mnt/root
$b mount -t overlay -o lowerdir=/,upperdir=/mnt/upper,workdir=/mnt/work overlay $new || $b poweroff -f
$b mount -t proc proc $new/proc && $b mount -t sysfs sysfs $new/sys && $b mount -t devtmpfs dev $new/dev
$b mkdir -p $new/dev/pts $new/dev/shm $new/desk
$b mount -t devpts devpts $new/dev/pts
$b mount -t tmpfs shm $new/dev/shm
$b mount -t hostfs -o "$DESK" desk $new/desk
net() { $b chroot $new "$b" ip link "$@"; }
net set lo up && net add vcan0 type vcan && net set vcan0 up
# Standard error goes where standard output does: the console is the only way out.
$b chroot $new /bin/bash -c ". /desk/command; echo \$? >/desk/status" 2>&1
$b sync
$b poweroff -f
'
