"""What a PDF is printed on."""

import re

A4_PT = (595, 842)


def sizes(pdf):
    """pt of each page as it is read; browsers write these uncompressed, pages across as turned ones."""
    found = []
    for page in re.findall(rb" obj\b(.*?)\bendobj", pdf, re.DOTALL):
        box = re.search(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)\s*\]", page)
        if box:
            size = round(float(box[1])), round(float(box[2]))
            found.append(size[::-1] if re.search(rb"/Rotate (90|270)\b", page) else size)
    return found
