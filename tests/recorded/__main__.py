"""Record answers anew: ``python -m tests.recorded [NAME ...]``."""

import sys

from tests.recorded.answers import all_cases, save

for name, case in all_cases().items():
    if not sys.argv[1:] or any(word in name for word in sys.argv[1:]):
        save(name, case())
        print(name)
