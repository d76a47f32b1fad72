"""`python -m kinemark`."""

from .apps.cli import main

main()
