"""The version of alight, where every layer can ask for it; `alight.__version__` to users."""

VERSION = "0.1.0"
