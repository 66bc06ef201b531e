#!/usr/bin/env bash
# Try lanewise with the newest Numba and NumPy that exist, pre-releases included, in an environment
# of its own: first with the NumPy that this Numba asks for, then with the newest one of all.
# NUMBA=0.69.0 tries that release instead, to find the one that broke something.
set -euo pipefail
cd "$(dirname "$0")/.."

environment=build/canary
"${PYTHON:-python3}" -m venv --clear "$environment"
install() {
    "$environment/bin/python" -m pip install --quiet --disable-pip-version-check \
        --only-binary :all: --pre --upgrade "$@"
}
canary() { LANEWISE_CACHE="$environment/cache" "$environment/bin/python" -m lanewise.canary; }
version() { "$environment/bin/python" -c 'from importlib.metadata import version; print(version("numpy"))'; }

install "numba${NUMBA:+==$NUMBA}"
status=0
canary || status=$?
asked=$(version)
install --no-deps numpy
if [ "$(version)" = "$asked" ]; then
    echo "NumPy $asked is the newest one"
else
    canary || status=$?
fi
exit "$status"
