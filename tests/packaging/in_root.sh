#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs inside an emulated root, where run.sh has put a Debian system and in /packages: install.deb, upgrade.deb (the next
# version, with another profile), next.deb (one more), geometry/<profile>/{calibration,pose}.yml. One line a check.
set -u
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
node=/etc/flume-srd/node.toml
profile=/usr/share/flume-srd/profiles/generic-v4l2/node.toml
unit=/usr/lib/systemd/system/flume-srd-node.service
# shellcheck source=tests/check.sh
. /packages/check.sh

apt() { apt-get -qq -y --no-install-recommends "$@" </dev/null; }
holds() { grep -qF -- "$2" "$1"; }
absent() { [ ! -e "$1" ]; }
version_is() { [ "$(srd-node --version)" = "$(dpkg-query -W -f '${source:Upstream-Version}' flume-srd-node)" ]; }

install() {
  apt install /packages/install.deb >/tmp/installed 2>&1 && return
  # A system that was made some time ago may name packages that the archive has replaced.
  apt update && apt install /packages/install.deb >/tmp/installed 2>&1 || { cat /tmp/installed; return 1; }
}
checks_every_profile() {
  for folder in /usr/share/flume-srd/profiles/*; do
    board=${folder##*/}
    mkdir -p "/tmp/check/$board"
    cp "$folder/node.toml" "/packages/geometry/$board/"*.yml "/tmp/check/$board/" || return 1
    echo "$board"
    srd-node --config "/tmp/check/$board/node.toml" --check-config || return 1
  done
}
modes_are_right() {
  dpkg -V flume-srd-node || return 1
  # Nothing of the package belongs to anybody but root or can be written by others.
  dpkg -L flume-srd-node | while read -r path; do
    [ -L "$path" ] || find "$path" -maxdepth 0 \( ! -user root -o ! -group root -o -perm /022 \)
  done >/tmp/wrong
  cat /tmp/wrong
  [ ! -s /tmp/wrong ] && [ "$(stat -c '%U %a' $node)" = "root 644" ]
}
has_its_user() {
  id flume-srd && id -nG flume-srd | grep -qw video && id -nG flume-srd | grep -qw gpio &&
    [ "$(getent passwd flume-srd | cut -d: -f7)" = /usr/sbin/nologin ]
}
has_its_folder() { stat -c '%U:%G %a' /var/lib/flume-srd && [ "$(stat -c '%U:%G %a' /var/lib/flume-srd)" = "flume-srd:flume-srd 750" ]; }
is_enabled() { [ -L /etc/systemd/system/multi-user.target.wants/flume-srd-node.service ]; }
waits_for_edits() { ! /usr/lib/flume-srd/configured $node && ! absent $node; }
detects() {
  printf '%s\0' "$1" >/tmp/model
  [ "$(SRD_MODEL_FILE=/tmp/model /usr/lib/flume-srd/detect-board)" = "$2" ]
}
refuses_the_key() {
  if srd-node --config $node --check-config >/tmp/key 2>&1; then return 1; fi
  cat /tmp/key
  holds /tmp/key "chmod 600 /etc/flume-srd/node.key"
}
key_is_the_services() { [ "$(stat -c '%U:%G %a' /etc/flume-srd/node.key)" = "flume-srd:flume-srd 400" ]; }
is_named() { dpkg-query -W -f '${Version}' flume-srd-node | grep -q "$1"; }
is_quiet() { ! "$@" 2>&1 | grep .; }

check "installs with its dependencies" install
[ "$failed" -eq 0 ] || exit 1
check "says what to do" holds /tmp/installed "edit node.id and node.host"
check "program is of the package's version" version_is
check "--help" srd-node --help
check "owners and modes" modes_are_right
check "configuration is the board's profile" cmp $node $profile
check "each profile passes --check-config" checks_every_profile
check "unit: systemd-analyze verify" is_quiet systemd-analyze --man=no verify $unit
check "unit: security at most 2.1" systemd-analyze security --offline=true --threshold=21 $unit
check "service is enabled" is_enabled
check "service waits while unedited" waits_for_edits
check "system user and its groups" has_its_user
check "state folder is the user's" has_its_folder
check "detects a Raspberry Pi 4" detects "Raspberry Pi 4 Model B Rev 1.5" raspberrypi-4
check "detects a Raspberry Pi 5" detects "Raspberry Pi 5 Model B Rev 1.0" raspberrypi-5
check "detects another board" detects "Radxa ROCK 5B" generic-v4l2
check "manual" sh -c 'zcat /usr/share/man/man1/srd-node.1.gz | grep -q "^.SH EXIT STATUS"'

check "upgrades" apt install /packages/upgrade.deb
check "upgrade has the next version" is_named +upgrade
check "unedited configuration follows the profile" holds $node "# profile of the upgrade"
sed -i 's/^id = "node-1"/id = "north-wall"/' $node
cp $node /tmp/edited
check "an edited configuration lets the service start" /usr/lib/flume-srd/configured $node
check "upgrades again" apt install /packages/next.deb
check "upgrade has the version after" is_named +next
check "edited configuration is kept by the upgrade" cmp $node /tmp/edited
cp /packages/geometry/generic-v4l2/calibration.yml /etc/flume-srd/
echo "flume-srd-key-1 north-wall $(printf '0123456789abcdef%.0s' 1 2 3 4)" >/etc/flume-srd/node.key
chmod 644 /etc/flume-srd/node.key
sed -i 's|^host = .*|&\nkey = "node.key"|' $node
cp $node /tmp/edited
cp /packages/geometry/generic-v4l2/pose.yml /etc/flume-srd/
check "a key that others can read is refused" refuses_the_key
check "installing again makes the key the service's own" apt install --reinstall /packages/next.deb
check "the key is the service's own" key_is_the_services
check "the service's user can read it" sh -c 'setpriv --reuid=flume-srd --regid=flume-srd --init-groups srd-node --config /etc/flume-srd/node.toml --check-config'
rm /etc/flume-srd/pose.yml
check "removes" apt remove flume-srd-node
check "the program is gone" absent /usr/bin/srd-node
check "edited configuration is kept by the removal" cmp $node /tmp/edited
check "installs again" apt install /packages/next.deb
check "edited configuration is still there" cmp $node /tmp/edited
check "service is enabled again" is_enabled
check "purges" apt purge flume-srd-node
check "purge takes the configuration" absent $node
check "purge takes the key" absent /etc/flume-srd/node.key
check "purge leaves a person's calibration" cmp /etc/flume-srd/calibration.yml /packages/geometry/generic-v4l2/calibration.yml
check "purge leaves no enabled service" absent /etc/systemd/system/multi-user.target.wants/flume-srd-node.service
rm -f /etc/flume-srd/calibration.yml
check "installs after a purge" install
check "a new configuration is the profile again" cmp $node $profile
check "purges all" apt purge flume-srd-node
check "nothing is left in /etc" absent /etc/flume-srd
check "nothing is left in /var/lib" absent /var/lib/flume-srd

if [ -e /packages/host.deb ]; then
  check "host: installs with its dependencies" apt install /packages/host.deb
  check "host: srd --version" srd --version
  check "host: srd simulate" srd simulate --default-scene
  check "host: removes" apt purge flume-srd
fi
exit "$failed"
