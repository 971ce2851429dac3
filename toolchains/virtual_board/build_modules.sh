#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# vimc and gpio-sim, which Debian's kernel packages lack, from Debian's kernel source against Debian's headers.
# usage: build_modules.sh FOLDER VERSION; FOLDER has headers/ and linux-source-6.1/; makes modules/
set -euo pipefail
cd -- "$1"
version=$2
headers=$PWD/headers/usr/src/linux-headers-$version-arm64
source=$PWD/linux-source-6.1

# The header packages name /usr/src absolutely.
grep -rlI "/usr/src/linux-headers" "$headers" --include=Makefile --include=.kernelvariables --include='*.mk' |
  while read -r file; do
    sed -i "s#[^ ]*/usr/src/linux-headers-$version#$PWD/headers/usr/src/linux-headers-$version#" "$file"
  done
mkdir -p modules/vimc modules/gpio
cp "$source"/drivers/media/test-drivers/vimc/*.[ch] modules/vimc/
# shellcheck disable=SC2016
sed 's/\$(CONFIG_VIDEO_VIMC)/m/' "$source/drivers/media/test-drivers/vimc/Makefile" >modules/vimc/Makefile
cp "$source"/drivers/gpio/gpio-sim.c "$source"/drivers/gpio/gpiolib.h modules/gpio/
# irq_to_desc is not exported to modules.
sed 's/handle_simple_irq(irq_to_desc(\([a-z]*\)))/generic_handle_irq(\1)/' "$source/kernel/irq/irq_sim.c" >modules/gpio/irq_sim_source.h
printf '#include <linux/module.h>\n#include "irq_sim_source.h"\nMODULE_LICENSE("GPL");\n' >modules/gpio/irq_sim.c
echo 'obj-m += irq_sim.o gpio-sim.o' >modules/gpio/Makefile
echo 'obj-m += vimc/ gpio/' >modules/Makefile
make -j2 -C "$headers" ARCH=arm64 CROSS_COMPILE=aarch64-linux-gnu- M="$PWD/modules" CONFIG_DEBUG_INFO_BTF_MODULES= modules
