"""What a long run says of itself meanwhile."""

import sys


def say(text):
    """Print `text` where progress belongs, at once."""
    print(text, file=sys.stderr, flush=True)
