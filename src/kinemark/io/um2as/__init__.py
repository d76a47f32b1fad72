"""The files of UM²AS (University of Manitoba Motion Analysis System; figures 3.5, 3.12, 3.17 and 3.21 of the thesis).

    .msr             measured places of the control balls       X Y Z, cm
    .cp1 .cp2 .cp3   eleven calibration parameters of a camera, one a line; the date in camera 1's file only
    .rf1 .rf2 .rf3   the reference marker when the camera was calibrated         U V, px
    .da1 .da2 .da3   digitised centroids, frame after frame, a line a marker     U V, px; header in camera 1's only
    .tdc             calculated places, likewise, with the header                X Y Z, cm
    .shd .elb .wst   angles of shoulder and wrist φ θ ψ and elbow φ ψ, a line a frame    deg

The number after the letters is the camera's; more than three cameras have `.cp4`, `.da4` and so on. 999 stands for what
is not there; it is NaN as soon as it is read. Lengths are cm in the files and mm everywhere else.
"""

from .angle_files import ENDINGS, read_angles, write_angles
from .calibration_files import (
    PER_LENGTH,
    Parameters,
    files_of_set,
    read_cp,
    read_cp_set,
    read_msr,
    read_rf,
    write_cp,
    write_msr,
    write_rf,
)
from .motion_files import read_da, read_da_set, read_tdc, trajectories_of_tdc, write_da, write_tdc
from .tab_tables import MM, TabHeader, camera_number

__all__ = [
    "ENDINGS",
    "MM",
    "PER_LENGTH",
    "Parameters",
    "TabHeader",
    "camera_number",
    "files_of_set",
    "read_angles",
    "read_cp",
    "read_cp_set",
    "read_da",
    "read_da_set",
    "read_msr",
    "read_rf",
    "read_tdc",
    "trajectories_of_tdc",
    "write_angles",
    "write_cp",
    "write_da",
    "write_msr",
    "write_rf",
    "write_tdc",
]
