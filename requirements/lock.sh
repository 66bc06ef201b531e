#!/usr/bin/env bash
# Write the locked requirements anew from pyproject.toml (needs uv on the path).
# The files name no package index, so that they work behind any mirror, and hold the hashes of the
# wheels of every platform; environment markers cover Python 3.11 to 3.13.
set -euo pipefail
cd "$(dirname "$0")/.."

lock() {
    local name=$1
    shift
    uv pip compile pyproject.toml "$@" --universal --python-version 3.11 --generate-hashes \
        --no-emit-index-url --no-emit-find-links --no-header --no-annotate --quiet \
        --output-file "requirements/$name.txt"
    sed -i '1i # Locked by requirements/lock.sh; change pyproject.toml and run it again.' \
        "requirements/$name.txt"
}

lock dev --extra dev --extra lab --extra denoise --extra gltf --extra usd --extra notebook --extra view --extra cluster --group build
# The smaller sets are constrained by the large one: one version of everything.
lock docs --extra docs --constraint requirements/dev.txt
lock peers --extra peers --constraint requirements/dev.txt
lock runtime --group build --constraint requirements/dev.txt
