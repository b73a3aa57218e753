"""``python -m radiosity``."""

from radiosity.cli.main import run

run()
