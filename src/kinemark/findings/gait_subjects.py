"""Whether the files of a gait report say that they are of one person."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..data import Finding, make_finding


def of_subjects(stated: Mapping[str, str]) -> Iterator[Finding]:
    """A finding where files state different subjects.

    Args:
        stated: the subject by the name of each file, walks and standing trial; empty where a file states none.
    """
    each: dict[str, list[str]] = {}
    for file, subject in stated.items():
        if plain := " ".join(subject.split()).casefold():
            each.setdefault(plain, []).append(file)
    if len(each) > 1:
        told = [f"{stated[files[0]]} ({', '.join(files)})" for files in each.values()]
        yield make_finding("gait_subjects_differ", subjects_list=told)
