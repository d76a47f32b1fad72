"""What may be found of what people said of a trial."""

from __future__ import annotations

from .finding import FindingKind as Kind

EDIT_KINDS = (
    Kind("edits_orphaned", "edit", "amber", "Edits that no longer find their place; they are kept and applied to "
         "nothing: the number of each entry, and why.", {"edits": "count", "entries_list": "text"}),
    Kind("edits_thin", "edit", "amber", "Edits that stand on few of their witnesses: the number of each entry, and "
         "how many were found.", {"edits": "count", "entries_list": "text"}),
    Kind("edits_unreadable", "edit", "amber", "Lines of the journal that are damaged, were changed, or are of a later "
         "version: the number of each line, and what is wrong.", {"lines": "count", "lines_list": "text"}),
    Kind("edits_applied", "edit", "info", "What became of the journal's entries: those that stand, that had nothing "
         "left to do, and that later ones took the place of.",
         {"entries": "count", "held": "count", "moot": "count", "overruled": "count"}),
)  # fmt: skip
