"""What a long run says of itself meanwhile."""

import sys

from ..arguments import checked


@checked
def say(text: str):
    """Print `text` where progress belongs, at once."""
    print(text, file=sys.stderr, flush=True)
