#!/usr/bin/env bash
# enter_debian_root.sh ROOT PROGRAM ARGS…, run in a mount namespace of its own: becomes PROGRAM
# inside ROOT, where the machine's own folders have the same paths as outside. Each step is an
# exec, so that signals, standard input and the exit code are the program's own.
set -euo pipefail
root=$1
shift
tools=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

bind() {
    mkdir -p "$root$1"
    mount --rbind "$1" "$root$1"
}

for system in /proc /dev /sys; do
    bind "$system"
done
for folder in /*/; do
    folder=${folder%/}
    case $folder in
    /bin | /boot | /dev | /etc | /lib* | /proc | /run | /sbin | /sys | /usr | /var | /lost+found) ;;
    *)
        if [ -L "$folder" ]; then
            ln -sfn "$(readlink "$folder")" "$root$folder"
        elif [ -r "$folder" ]; then
            bind "$folder"
        fi
        ;;
    esac
done
# These may lie in a system folder all the same; one that is there already is left alone.
for folder in "$PWD" "$tools/.." "${HOME:-/}" "${TMPDIR:-/tmp}" "${XDG_CACHE_HOME:-/tmp}" \
    "${XDG_RUNTIME_DIR:-/tmp}"; do
    folder=$(realpath -m "$folder")
    if [ -d "$folder" ] && ! [ "$folder" -ef "$root$folder" ]; then
        bind "$folder"
    fi
done

# What the arguments name may lie in a system folder too (/var/tmp, /run/media): inside, a result
# there would end in the root, where nobody looks for it. What the root itself needs stays its own.
for argument; do
    folder=$(realpath -m -- "${argument#-*=}" 2>/dev/null) || continue
    until [ -d "$folder" ]; do
        folder=$(dirname "$folder")
    done
    case $folder in
    / | /run | /var | /var/cache | /var/lib) ;;
    /run/* | /var/*) [ "$folder" -ef "$root$folder" ] || bind "$folder" ;;
    *) [ -n "$(ls -A "$root$folder" 2>/dev/null)" ] || bind "$folder" ;;
    esac
done

# Mesa maps the index of its compiled shaders into memory and cuts that file to the length that its
# version wants (1,310,728 bytes in 25.0, 2,097,160 in 26.2). Beside the machine's own programs, of
# another version, one would shorten it under the other, which ends a program by SIGBUS.
mkdir -p "$root/var/cache/mesa"
export MESA_SHADER_CACHE_DIR=/var/cache/mesa

# Libraries and Python settings of the machine outside would not fit the programs inside, and its
# language is not installed there.
unset LD_LIBRARY_PATH LD_PRELOAD PYTHONHOME
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8
exec chroot "$root" /usr/bin/env --chdir="$PWD" "$@"
