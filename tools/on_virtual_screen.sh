#!/usr/bin/env bash
# on_virtual_screen.sh PROGRAM ARGS…: runs it with an X screen of its own and passes on its exit
# code. (xvfb-run guesses a free display number, which two at once can both get; Xvfb itself
# finds one safely when it is asked to say which.)
set -euo pipefail
folder=$(mktemp -d)
program='' screen=''
finish() {
    [ -z "$program" ] || kill "$program" 2>/dev/null || true
    [ -z "$screen" ] || kill "$screen" 2>/dev/null || true
    rm -rf "$folder"
}
trap finish EXIT
trap 'exit 143' TERM
trap 'exit 130' INT

mkfifo "$folder/display"
Xvfb -displayfd 3 -screen 0 1600x900x24 -nolisten tcp \
    3>"$folder/display" >"$folder/log" 2>&1 </dev/null &
screen=$!
if ! read -r display <"$folder/display"; then
    cat "$folder/log" >&2
    exit 1
fi
# A Wayland session outside must not get the window.
unset WAYLAND_DISPLAY
export DISPLAY=:$display
# In the background, so that a signal is acted on at once; `<&0` leaves it standard input.
"$@" <&0 &
program=$!
code=0
wait "$program" || code=$?
program=''
exit "$code"
