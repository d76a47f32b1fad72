"""Types of which what quality.json holds is declared."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field
from pydantic.config import with_config

Share = Annotated[float, Field(ge=0, le=1)] | None
Count = Annotated[int, Field(ge=0)]
Number = float | None
Pair = Annotated[list[Number], Field(min_length=2, max_length=2)]
Point = Annotated[list[Number], Field(min_length=3, max_length=3)]
Box = Annotated[list[Point], Field(min_length=2, max_length=2)]

documented = with_config(ConfigDict(use_attribute_docstrings=True, extra="forbid"))
"""The docstrings below become the descriptions of the schema, and other keys are errors."""
