"""What all tables of the file have in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Strict(BaseModel):
    """A table of the file; a key that it does not know is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)
