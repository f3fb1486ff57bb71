#!/bin/sh
# Renders one scene: ./hil/render_scene.sh SCENE.toml OUT [--variant NAME] [--threads N] [--check]
# Needs Debian's blender (3.4) and python3-numpy, and installs them where they are missing.
# Exit status: 0 done, 1 failed, 2 refused before rendering.
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in
  -h | --help)
    sed -n '2,4s/^# //p' "$0"
    echo "Example: ./hil/render_scene.sh hil/scenes/paper_3d.toml OUT --variant small"
    exit 0 ;;
esac
here=$(cd "$(dirname "$0")" && pwd)
if ! command -v blender >/dev/null 2>&1; then
  echo "render_scene: blender is not installed; calling tools/setup.sh renderer" >&2
  if ! "$here/../tools/setup.sh" renderer >&2 || ! command -v blender >/dev/null 2>&1; then
    echo "render_scene: blender can't be installed; do it by hand: apt-get install --no-install-recommends blender python3-numpy" >&2
    exit 2
  fi
fi
# Our own lines go to stderr; stdout carries only Blender's greeting.
# Blender takes the libraries of the first Python in PATH, and numpy is beside the distribution's own.
blender=$(command -v blender)
PATH="/usr/bin:/bin:$PATH" PYTHONPATH="$here/../tools" exec "$blender" --background --factory-startup --python-use-system-env \
  --python-exit-code 1 --python-expr "from polhode_ground.scenes.main import main; main()" -- "$@" >/dev/null
