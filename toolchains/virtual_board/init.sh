#!/bin/busybox sh
# shellcheck shell=dash
# SPDX-License-Identifier: Apache-2.0
# The emulated board's first process: root image below a writable layer, the work folder in /w, then /w/on_board.sh.
busybox=/bin/busybox
$busybox mount -t proc proc /proc
$busybox mount -t sysfs sys /sys
$busybox mount -t devtmpfs dev /dev
for name in cat chroot insmod mkdir modprobe mount poweroff sh switch_root sync; do $busybox ln -s busybox /bin/$name; done
$busybox mkdir -p /sbin
for module in virtio_pci virtio_mmio virtio_blk virtio_net crc32c_generic ext4 9pnet_virtio 9p overlay configfs; do modprobe $module; done
# Drives appear after their driver, one by one.
for _ in 1 2 3 4 5 6 7 8 9 10; do [ -b /dev/vda ] && [ -b /dev/vdb ] && break; $busybox sleep 0.2; done
mount -t ext4 -o ro /dev/vda /r || echo "no root image"
mkdir -p /layer /n
mount -t tmpfs layer /layer
mkdir -p /layer/upper /layer/work
mount -t overlay -o lowerdir=/r,upperdir=/layer/upper,workdir=/layer/work root /n || echo "no writable layer"
mkdir -p /n/proc /n/sys /n/dev /n/tmp /n/run /n/w /n/debian13 /n/lib/modules
mount -t 9p -o trans=virtio,version=9p2000.L,msize=512000 work /n/w || echo "no work folder"
mount -o move /dev /n/dev
mount -o bind /sys /n/sys
mount -t proc proc /n/proc
mount -t tmpfs tmp /n/tmp
mount -t tmpfs run /n/run
mkdir -p /n/dev/pts /n/dev/shm
mount -t tmpfs shm /n/dev/shm
mount -t configfs config /n/sys/kernel/config || echo "no configfs"
mount -t ext4 -o ro /n/dev/vdb /n/debian13 || echo "no Debian 13 image"
$busybox cp -a /lib/modules/. /n/lib/modules/
$busybox cp /bin/busybox /n/bin/busybox.board

cat >/n/start <<'START'
#!/bin/busybox.board sh
export PATH=/usr/sbin:/usr/bin:/sbin:/bin:/busybox HOME=/tmp TERM=dumb
export LD_LIBRARY_PATH=/usr/lib/aarch64-linux-gnu/blas:/usr/lib/aarch64-linux-gnu/lapack
/bin/busybox.board mkdir -p /busybox
/bin/busybox.board --install -s /busybox
ifconfig lo up
ifconfig eth0 10.0.2.15 netmask 255.255.255.0 up || echo "no network card"
for into in proc sys dev tmp run w; do mount -o rbind /$into /debian13/$into; done 2>/dev/null
cd /w
bash /w/on_board.sh
echo $? >/w/exit_code
sync
poweroff -f
START
$busybox chmod +x /n/start
$busybox umount /proc /sys
# BOARD_INIT: of the kernel's command line, another first process of the root image, such as systemd.
exec $busybox switch_root /n "${BOARD_INIT:-/start}"
