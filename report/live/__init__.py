"""The study as pages that run it, without Python or a server: `make live`."""
