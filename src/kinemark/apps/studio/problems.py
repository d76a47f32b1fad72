"""What is probably wrong with a trial, the costliest first."""

from __future__ import annotations
