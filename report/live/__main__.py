"""Make the pages that run: `make live`."""

from report.live.build import LIVE, build
from report.site.publish import publish

LARGEST = 120e6  # bytes, of all

if __name__ == "__main__":
    publish(build, LIVE, LARGEST)
