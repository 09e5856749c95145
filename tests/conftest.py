"""Hypothesis draws the same examples in every run, so that a test passes or fails for good."""

from hypothesis import settings

settings.register_profile("study", derandomize=True, deadline=None)
settings.load_profile("study")
