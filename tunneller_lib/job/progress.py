"""What a long run says of itself meanwhile."""

import sys

from ..arguments import checked
from ..terminal import fit


@checked
def say(text: str):
    """Print `text` where progress belongs, at once."""
    print(fit(text), file=sys.stderr, flush=True)
