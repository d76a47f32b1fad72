"""`python -m kinemark`."""

from .cli import main

main()
