"""What holds for all tests: garbage is not looked for among the tests themselves."""

import gc

import pytest


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    # Thousands of tests are made, and none of them is garbage; later, a collection that looks at
    # what the session holds to its end would take a second each time.
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()
