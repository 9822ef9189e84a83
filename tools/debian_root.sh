# Sourced by choose_blender.sh: a Debian root file system with Blender, in the user's cache.
#   provide_debian_root SUITE        sets debian_root, building it first if it is not there
#   enter_debian_root ROOT PROGRAM…  becomes that program, inside
# Only the package manager's own signatures are trusted; nothing is installed on the machine
# itself but mmdebstrap, which builds the root, and that only when run by root.

# The second line is what Blender's own extension commands import (without these they fail to
# register), the third software rendering, the fourth a window to look at.
debian_packages=(
    blender python3-numpy python3-scipy
    python3-requests python3-cattr python3-cachecontrol
    libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri
    xvfb xauth imagemagick xdotool fonts-dejavu-core
)

# Some services start programs without HOME; bash knows it from the list of users.
export HOME=${HOME:-$(echo ~)}
umbilics_cache=${XDG_CACHE_HOME:-$HOME/.cache}/umbilics

provide_debian_root() {
    local suite=$1 recipe
    # Another list of packages is another root.
    recipe=$(printf '%s\n' "${debian_packages[@]}" | cksum | cut -d ' ' -f 1)
    debian_root=$umbilics_cache/blender/debian-$suite-$recipe
    [ -d "$debian_root" ] && return
    mkdir -p "$umbilics_cache/blender"
    # The lock ends with the subshell, however it ends.
    (
        flock --nonblock 9 || { say "waiting for another set-up of Blender to end …" && flock 9; }
        [ -d "$debian_root" ] || build_debian_root "$suite"
    ) 9>"$debian_root.lock"
}

build_debian_root() {
    local suite=$1 partial=$debian_root.partial log=$debian_root.log
    local mirror mirrors=() seconds=$SECONDS
    can_build_debian_root || return 1
    say "setting up Blender from Debian's packages ($suite), once: about 350 MB to download," \
        "1.3 GB in $umbilics_cache/blender, one to three minutes …"
    # The mirror that this machine's own apt uses, if that is Debian's; then the public one.
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 2>/dev/null |
        grep -m 1 -E '/debian/?$' || true)
    [ -z "$mirror" ] || mirrors+=("${mirror%/}")
    [ "${mirror%/}" = http://deb.debian.org/debian ] || mirrors+=(http://deb.debian.org/debian)
    for mirror in "${mirrors[@]}"; do
        # Left over from a set-up that was killed.
        rm -rf --one-file-system "$partial"
        mkdir -p "$partial"
        if bootstrap "$suite" "$mirror" "$partial" >"$log" 2>&1 </dev/null; then
            mv "$partial" "$debian_root"
            say "Blender is ready: $(du -sh "$debian_root" | cut -f 1)," \
                "$((SECONDS - seconds)) seconds."
            return
        fi
    done
    rm -rf --one-file-system "$partial"
    say "setting it up from $suite failed; the end of $log:"
    tail -n 5 "$log" >&2
    explain_network "$log"
    return 1
}

can_build_debian_root() {
    if ! command -v apt-get >/dev/null || ! command -v dpkg >/dev/null; then
        say "there is no Blender 4.2 or later here, and this is not a Debian or Ubuntu system."
        return 1
    fi
    if ! unshare "${unshare_options[@]}" true 2>/dev/null; then
        say "there is no Blender 4.2 or later here, and this user may not make a root file" \
            "system for one (mount namespaces are not allowed)."
        return 1
    fi
    if [ "$(id -u)" != 0 ] && ! has_subuids "$(id -un)"; then
        say "there is no Blender 4.2 or later here, and $(id -un) may not make a root file system" \
            "for one: no range of user numbers in /etc/subuid and /etc/subgid. This gives one:"
        say "  sudo usermod --add-subuids 100000-165535 --add-subgids 100000-165535 $(id -un)"
        return 1
    fi
    if [ "$(id -u)" != 0 ]; then
        if ! command -v mmdebstrap >/dev/null || ! command -v newuidmap >/dev/null; then
            say "there is no Blender 4.2 or later here; to set one up, mmdebstrap or newuidmap is" \
                "missing: sudo apt install mmdebstrap uidmap"
            return 1
        fi
    elif ! command -v mmdebstrap >/dev/null; then
        say "installing mmdebstrap with apt-get, to build a root file system with Blender …"
        apt_get_install mmdebstrap debian-archive-keyring || return 1
    fi
}

# Whether a user has numbers for the users of a root file system of their own.
has_subuids() {
    grep -qs "^\($1\|$(id -u)\):" /etc/subuid && grep -qs "^\($1\|$(id -u)\):" /etc/subgid
}

# Says so if a log is that of a failure to reach a server.
explain_network() {
    if grep -qiE 'resolv|could not connect|cannot initiate|unreachable|timed out|connection failed' \
        "$1"; then
        say "the server of the packages could not be reached. This needs the network once; behind a" \
            "proxy, set Acquire::http::Proxy for apt. Without a network, install Blender by hand."
    fi
}

apt_get_install() {
    local log
    log=$(mktemp)
    # The package lists may be missing or older than what the mirror still has.
    if ! DEBIAN_FRONTEND=noninteractive apt-get install -y "$@" >"$log" 2>&1 </dev/null &&
        ! { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y "$@"; } \
            >"$log" 2>&1 </dev/null; then
        say "apt-get install $* failed:"
        tail -n 5 "$log" >&2
        explain_network "$log"
        rm -f "$log"
        return 1
    fi
    rm -f "$log"
}

# Root sees its own mounts in a namespace; anyone else needs a user namespace around that.
if [ "$(id -u)" = 0 ]; then
    unshare_options=(--mount)
else
    unshare_options=(--mount --map-root-user)
fi

bootstrap() {
    local suite=$1 mirror=$2 folder=$3 proxy
    local options=(
        --variant=apt --include="$(IFS=, && echo "${debian_packages[*]}")"
        # sid's index can be marked as expired; its signature is checked all the same.
        --aptopt='Acquire::Check-Valid-Until "false"'
        --aptopt='Acquire::Languages "none"' --aptopt='Acquire::Retries "3"'
        --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*'
        --dpkgopt='path-exclude=/usr/share/doc/*'
        --dpkgopt='path-include=/usr/share/doc/*/copyright'
        # Blender reads the list of drives there.
        --customize-hook='ln -sf /proc/self/mounts "$1/etc/mtab"'
    )
    proxy=$(apt-config dump --format '%v' Acquire::http::Proxy)
    [ -z "$proxy" ] || options+=(--aptopt="Acquire::http::Proxy \"$proxy\"")
    if [ "$(id -u)" = 0 ]; then
        mmdebstrap --mode=root "${options[@]}" "$suite" "$folder" "$mirror"
    else
        # Through tar, so that every file is the user's own and can be deleted again.
        mmdebstrap --mode=unshare "${options[@]}" "$suite" - "$mirror" |
            tar --extract --no-same-owner --exclude='./dev/*' --directory "$folder"
    fi && is_new_enough "$(version_of \
        unshare "${unshare_options[@]}" bash "$tools/enter_debian_root.sh" "$folder" blender)"
}

enter_debian_root() {
    exec unshare "${unshare_options[@]}" --propagation private -- \
        bash "$tools/enter_debian_root.sh" "$@"
}
