# Sourced; $tools is the folder of this file. run_python MODULE SCRIPT ARGS… becomes the Python
# script, run by a Python 3.11 or later that has the module, which root installs if need be.
. "$tools/choose_blender.sh"

find_python() {
    local candidate
    for candidate in python3 python3.14 python3.13 python3.12 python3.11 /usr/bin/python3; do
        if "$candidate" -c "import sys, $1; sys.exit(sys.version_info < (3, 11))" 2>/dev/null; then
            python=$candidate
            return
        fi
    done
    return 1
}

run_python() {
    local module=$1 python=''
    shift
    if ! find_python "$module" && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        say "installing python3 and python3-venv with apt-get …"
        apt_get_install python3 python3-venv && find_python "$module" || true
    fi
    if [ -z "$python" ]; then
        say "this needs Python 3.11 or later (on Debian and Ubuntu: sudo apt install" \
            "python3 python3-venv)."
        exit 1
    fi
    exec "$python" "$@"
}
