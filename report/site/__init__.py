"""The study as web pages that need neither a server nor a network: `make site`."""
