"""Commands keep no programs of tests in the user's cache."""

import pytest


@pytest.fixture(autouse=True)
def no_user_cache(monkeypatch):
    monkeypatch.setenv("CPR_JAX_CACHE", "")
