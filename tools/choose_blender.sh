# Sourced by tools/blender and tools/window; $tools is the folder of this file.
# choose_blender sets exactly one of
#   blender_program   a Blender of this machine
#   blender_root      a Debian root file system that has Blender inside
. "$tools/debian_root.sh"

say() { printf 'umbilics: %s\n' "$*" >&2; }

# Prints a program's Blender version, such as 4.5.3; nothing if it has none.
version_of() {
    "$@" --version 2>/dev/null </dev/null | sed -n 's/^Blender \([0-9][0-9.]*\).*/\1/p' | head -n 1
}

is_new_enough() {
    [ -n "$1" ] && [ "$(printf '4.2\n%s\n' "$1" | sort -V | head -n 1)" = 4.2 ]
}

how_to_install() {
    say "$1"
    cat >&2 <<'END'
Install Blender 4.2 or later, in any of these ways, and try again:
  - from https://www.blender.org/download/
  - Debian 13 or later:  sudo apt install blender python3-numpy python3-scipy
  - Linux with snap:     sudo snap install blender --classic
  - macOS with Homebrew: brew install --cask blender
If it is then not on PATH as `blender`, name it:  export BLENDER=/path/to/blender
END
    exit 1
}

choose_blender() {
    blender_program='' blender_root=''
    if [ -n "${BLENDER:-}" ]; then
        blender_program=$(command -v "$BLENDER") ||
            how_to_install "\$BLENDER is $BLENDER, which is not a program."
        return
    fi
    case ${UMBILICS_BLENDER:-} in
    '')
        local found version
        found=$(command -v blender || true)
        # This very script may be what PATH finds, or a program that calls it, for ever then.
        if [ -n "$found" ] && ! [ "$found" -ef "$tools/blender" ] &&
            [ -z "${UMBILICS_ASKS_PATH:-}" ]; then
            export UMBILICS_ASKS_PATH=1
            version=$(version_of "$found" || true)
            if is_new_enough "$version"; then
                blender_program=$found
                return
            fi
            say "$found is Blender ${version:-of an unknown version}; 4.2 or later is needed."
        fi
        # Debian's development suite is not always installable; its stable one is.
        provide_debian_root sid || provide_debian_root trixie ||
            how_to_install "No Blender could be set up from Debian's packages."
        ;;
    5.2) provide_debian_root sid || how_to_install "Blender 5.2 could not be set up." ;;
    4.3) provide_debian_root trixie || how_to_install "Blender 4.3 could not be set up." ;;
    *) how_to_install "UMBILICS_BLENDER is $UMBILICS_BLENDER; it may be 5.2 or 4.3." ;;
    esac
    blender_root=$debian_root
}
