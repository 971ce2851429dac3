# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
# Sourced by the scripts of this folder: Debian packages of any release and architecture, unpacked into a folder.
# Nothing is installed, no foreign architecture is added to the machine, no root is needed.

# The machine's own Debian source, whatever release it names.
debian_source() {
  local source
  source=$(apt-get indextargets --format '$(REPO_URI) $(ORIGIN) $(COMPONENT)' 'Created-By: Packages' 2>/dev/null |
    awk '$2 == "Debian" && $3 == "main" && $1 !~ /security/ {print $1; exit}')
  if [ -z "$source" ]; then
    echo "${0##*/}: this machine's package sources name no Debian archive (apt-get indextargets)." >&2
    echo "  expected: Debian 12 or newer with a source of the component main; try: apt-get update, as root" >&2
    return 1
  fi
  echo "$source"
}

debian_codename() { # number of the release
  case $1 in
    12) echo bookworm ;;
    13) echo trixie ;;
    *) echo "${0##*/}: no Debian $1 here: expected 12 or 13" >&2; return 1 ;;
  esac
}

# A package state of its own, that knows nothing of this machine's packages, so that every dependency is fetched.
debian_state() { # folder, release, architecture
  local state=$1 codename archive keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  codename=$(debian_codename "$2")
  archive=$(debian_source)
  mkdir -p "$state"/etc/preferences.d "$state"/etc/sources.list.d "$state"/lists/partial "$state"/cache/archives/partial "$state"/log
  : >"$state/status"
  {
    echo "deb [signed-by=$keyring] $archive $codename main"
    echo "deb [signed-by=$keyring] $archive $codename-updates main"
  } >"$state/etc/sources.list"
  cat >"$state/apt.conf" <<CONF
APT::Architecture "$3";
APT::Architectures { "$3"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Retries "2";
Debug::NoLocking "true";
Dir::Etc::SourceList "$state/etc/sources.list";
Dir::Etc::SourceParts "$state/etc/sources.list.d";
Dir::Etc::PreferencesParts "$state/etc/preferences.d";
Dir::State::Lists "$state/lists";
Dir::State::Status "$state/status";
Dir::Cache "$state/cache";
Dir::Log "$state/log";
CONF
  apt-get -c "$state/apt.conf" -qq update
}

# Unpacks a package and notes it in the folder's own dpkg database, which tells dpkg-shlibdeps who owns a library.
debian_unpack() { # folder, package file
  local to=$1 file=$2 fields name info=$1/var/lib/dpkg/info
  fields=$(dpkg-deb -f "$file")
  name=$(sed -n 's/^Package: //p' <<<"$fields")
  ! grep -q '^Multi-Arch: same' <<<"$fields" || name=$name:$(sed -n 's/^Architecture: //p' <<<"$fields")
  {
    echo /.
    dpkg-deb --fsys-tarfile "$file" |
      tar -C "$to" -xvf - --exclude=./usr/share/doc --exclude=./usr/share/man --exclude=./usr/share/locale \
        --keep-directory-symlink | sed -e 's,^\.,,' -e 's,/$,,' -e '/^$/d'
  } >"$info/$name.list"
  dpkg-deb --ctrl-tarfile "$file" | tar -C "$info" --transform "s,^\./,$name.," -xf - --wildcards './s*' 2>/dev/null || true
  sed -e '1a Status: install ok installed' <<<"$fields" >"$info/$name.status"
}

# Fetches packages with all that they depend on, and unpacks them.
debian_packages() { # folder, release, architecture, packages...
  local to=$1 release=$2 architecture=$3 state link target
  shift 3
  mkdir -p "$to/var/lib/dpkg/info"
  if [ "$release" -ge 13 ]; then  # its packages have /usr alone; the links are base-files'
    for link in bin lib sbin; do
      mkdir -p "$to/usr/$link"
      ln -s "usr/$link" "$to/$link"
    done
  fi
  state=$(mktemp -d)
  debian_state "$state" "$release" "$architecture"
  apt-get -c "$state/apt.conf" -qq -y --download-only install "$@" >/dev/null
  export -f debian_unpack
  printf '%s\0' "$state"/cache/archives/*.deb |
    xargs -0 -n 20 -P "$(nproc)" bash -euo pipefail -c 'to=$1; shift; for file; do debian_unpack "$to" "$file"; done' bash "$to"
  sed 's/^Package:/\n&/' "$to"/var/lib/dpkg/info/*.status >"$to/var/lib/dpkg/status"
  rm -rf "$state" "$to"/var/lib/dpkg/info/*.status
  # Absolute links would lead out of the folder.
  find "$to" -type l -lname '/*' -printf '%p\t%l\n' | while IFS=$'\t' read -r link target; do
    ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$to$target")" "$link"
  done
  # What update-alternatives would have done.
  local libraries name
  for libraries in "$to"/usr/lib/*-linux-gnu*; do
    for name in blas lapack; do
      [ ! -e "$libraries/$name/lib$name.so.3" ] || ln -sfn "$name/lib$name.so.3" "$libraries/lib$name.so.3"
    done
  done
}
