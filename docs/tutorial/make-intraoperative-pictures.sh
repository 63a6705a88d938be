#!/bin/sh
# Makes the pictures of intraoperative.md with the GUI test, on the phantom. $1: build folder.
set -e
build=$(realpath "${1:-build/release}")
images=$(dirname "$(realpath "$0")")/images
mkdir -p "$images"
(cd "$build" && ctest -R '^MakeTestPhantom$' --output-on-failure)
KERF_GUI_PICTURES="$images" "$build/bin/IntraoperativeGuiTests"
