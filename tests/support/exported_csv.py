"""CSV as other programs export it, from trajectories: Vicon Nexus and OptiTrack's Motive."""

from __future__ import annotations

import math

from kinemark.data import Trajectories

METRES = {"Meters": 1000.0, "Centimeters": 10.0, "Millimeters": 1.0}
DEVICES = """Devices
{rate}
,,AMTI #1 - Force,,,AMTI #1 - Moment,,,EMG - Voltage,
Frame,Sub Frame,Fx,Fy,Fz,Mx,My,Mz,LTA,RTA
,,N,N,N,N.mm,N.mm,N.mm,V,V
"""
EVENTS = """Events
100
Subject,Context,Name,Time (s),Description
Anna,Left,Foot Strike,1.03,The instant the heel strikes the ground.
Anna,Right,Foot Off,1.14,The instant the toe leaves the ground.
"""
ANGLES = """Model Outputs
100
,,Anna:LKneeAngles,,
Frame,Sub Frame,X,Y,Z
,,deg,deg,deg
1,0,1,2,3
"""


def cell(value: float, mm: float = 1.0) -> str:
    """A coordinate in the file's unit, to six digits of the unit's as both programs round; empty for a gap."""
    return "" if math.isnan(value) else f"{value / mm:.6f}"


def nexus(t: Trajectories, *, devices: int = 0, events: bool = False, moving: bool = False) -> str:
    """As Nexus writes "ASCII": devices with so many samples a frame, events, velocities beside the places."""
    blocks = [EVENTS] if events else []
    if devices:
        rows = [
            ",".join([str(f + t.first_frame), str(s), *(f"{100 * k + f + s / 10:g}" for k in range(8))])
            for f in range(t.n_frames)
            for s in range(devices)
        ]
        blocks.append(DEVICES.format(rate=f"{t.rate * devices:g}") + "\n".join(rows) + "\n")
    blocks.append(ANGLES)
    more = ["X'", "Y'", "Z'"] if moving else []
    wide = ["", "", *(c for name in t.names for c in (f"Anna:{name}", "", "", *[""] * len(more)))]
    lines = [
        ",".join(wide),
        ",".join(["Frame", "Sub Frame", *(c for _ in t for c in ("X", "Y", "Z", *more))]),
        ",".join(["", "", *(c for _ in t for c in (*["mm"] * 3, *["mm/s"] * len(more)))]),
    ]
    for f in range(t.n_frames):
        cells = (c for path in t for c in (*map(cell, path.xyz[f]), *["7.5"] * len(more)))
        lines.append(",".join([str(f + t.first_frame), "0", *cells]))
    blocks.append(f"Trajectories\n{t.rate:g}\n" + "\n".join(lines) + "\n")
    return "\n\n".join(blocks)


def motive(t: Trajectories, *, unit: str = "Meters", words: bool = True, time_code: bool = False) -> str:
    """As Motive writes it, with a rigid body, its expected markers and its error before the markers."""
    body = ["Rigid Body"] * 8 + ["Rigid Body Marker"] * 4
    whose = ["Foot"] * 8 + ["Foot:Marker1"] * 4
    what = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"] + ["Position"] * 3 + ["Marker Quality"]
    axes = ["X", "Y", "Z", "W", "X", "Y", "Z", "", "X", "Y", "Z", ""]
    pad = [""] * time_code
    three = [name for name in t.names for _ in "XYZ"]
    heading = {
        "Format Version": "1.23", "Take Name": "walk", "Take Notes": "", "Capture Frame Rate": f"{2 * t.rate:.6f}",
        "Export Frame Rate": f"{t.rate:.6f}", "Total Exported Frames": str(t.n_frames), "Rotation Type": "Quaternion",
        "Length Units": unit, "Coordinate Space": "Global",
    }  # fmt: skip
    rows = [
        [cell for pair in heading.items() for cell in pair],
        [],
        ["", "Type" * words, *pad, *body, *["Marker"] * len(three)],
        ["", "Name" * words, *pad, *whose, *three],
        ["", "ID" * words, *pad, *["4CF0"] * len(body), *["9F:1"] * len(three)],
        ["", "", *pad, *what, *["Position"] * len(three)],
        ["Frame", "Time (Seconds)", *["TimeCode"] * time_code, *axes, *list("XYZ") * len(t)],
    ]
    for f in range(t.n_frames):
        stamp = [f"15:26:46:{f:02d}.0"] * time_code
        places = [cell(x, METRES[unit]) for path in t for x in path.xyz[f]]
        rows.append([str(f + t.first_frame), f"{f / t.rate:.6f}", *stamp, *["0.5"] * len(body), *places])
    return "".join(",".join(row) + "\n" for row in rows)
