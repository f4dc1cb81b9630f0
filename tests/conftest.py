"""Settings for all tests."""

from hypothesis import settings

# The same examples in every run, on however slow a machine: no test fails by chance.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")
