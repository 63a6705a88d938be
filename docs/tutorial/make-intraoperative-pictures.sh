#!/bin/sh
# Makes the pictures and the video of intraoperative.md from the running window, on the phantom.
#   docs/tutorial/make-intraoperative-pictures.sh [BUILD [OUTPUT [WIDTH HEIGHT dark|light]]]
set -e
build=$(realpath "${1:-build/release}")
images=${2:-$(dirname "$(realpath "$0")")/images}
mkdir -p "$images"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$build/bin/kerf" phantom --scenario kidney-cut --output "$work/study" --quiet
set -- "$build/bin/IntraoperativeTour" "$work/study" "$images" "${3:-1280}" "${4:-800}" "${5:-dark}" "$work/case"
if [ -z "$DISPLAY" ]; then set -- xvfb-run -a -s "-screen 0 1920x1080x24" "$@"; fi
"$@"
# The video: the last session, done again.
session=$(ls -d "$work"/case/sessions/* | tail -n 1)
"$build/bin/kerf" replay "$session" --output "$work/replayed" --quiet
cp "$work/replayed/overlay.mp4" "$images/intraoperative-overlay.mp4"
