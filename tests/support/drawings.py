"""Figures of the report checked by Plotly's own graph objects, which a run leaves out for speed."""

import json

import plotly.graph_objects as go

from support.pages import data_of


def checked(figure):
    """Plotly's graph object of a figure of ours, of which it knows every key and value as they stand."""
    check_plotly_reads(json.loads(figure.to_json()))
    return go.Figure(figure.data, figure.layout)


def check_page(html):
    """Refuse a page with a drawing that Plotly does not know; gives the places of its drawings."""
    drawn = {place: spec for place, spec in data_of(html).items() if "layout" in spec}
    for spec in drawn.values():
        check_plotly_reads(spec)
    return [*drawn]


def check_plotly_reads(spec):
    """Refuse a drawing (data and layout, of JSON) that Plotly does not know, or would say in another way."""
    again = json.loads(go.Figure(spec["data"], spec["layout"]).to_json())
    again["layout"].pop("template")  # Plotly's own of Python, which a page has not
    assert again == {"data": spec["data"], "layout": spec["layout"]}
