"""Scenes in tests: drawn smaller than for the report, and colours that are found in pictures."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from kit import COLOURS, scene


@pytest.fixture(autouse=True, scope="module")
def small_scenes():
    """Draw scenes on half of the pixels each way, a fourth of the work."""
    width, height = scene.THEME.window_size
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene.THEME, "window_size", [width // 2, height // 2])
        yield


def share(picture, colour):
    """Return which share of a picture has nearly the hue of one of the study's colours."""
    seen, wanted = picture / 255, np.array(to_rgb(COLOURS[colour]))
    seen, wanted = (x - x.mean(axis=-1, keepdims=True) for x in (seen, wanted))
    size = np.linalg.norm(seen, axis=-1)
    along = seen @ wanted / np.linalg.norm(wanted)
    return np.mean((size > 0.15) & (along > 0.97 * size))
