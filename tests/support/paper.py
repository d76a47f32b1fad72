"""What a PDF is printed on."""

import re

A4_PT = (595, 842)


def sizes(pdf):
    """pt of each page; browsers write these uncompressed."""
    boxes = re.findall(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)\s*\]", pdf)
    return [(round(float(w)), round(float(h))) for w, h in boxes]
