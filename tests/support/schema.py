"""Checks of figures against the schema that is shipped."""

from functools import cache

import jsonschema

from kinemark.findings.schema import quality_schema


@cache
def _validator(part):
    schema = quality_schema()
    if part:
        schema = {"$schema": schema["$schema"], "$ref": f"#/$defs/{part}", "$defs": schema["$defs"]}
    return jsonschema.Draft202012Validator(schema)


def check_quality(figures):
    """Of one trial, as quality.json holds them."""
    _validator("").validate(figures)


def check_findings(figures):
    """The findings and the verdict of any figures."""
    _validator("VerdictData").validate(figures["verdict"])
    for one in figures["findings"]:
        _validator("FindingData").validate(one)
