"""Make the pages: `make site`."""

from report.site.build import SITE, build
from report.site.publish import publish

LARGEST = 64e6  # bytes that can be published without much ado

if __name__ == "__main__":
    publish(build, SITE, LARGEST)
