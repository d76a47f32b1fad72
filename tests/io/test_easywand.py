"""MATLAB files and calibrations of easyWand: what was saved comes back, damaged files are refused, real wands fit."""

import struct

import numpy as np
import pytest
from scipy.io import savemat

from kinemark.data import KinemarkError
from kinemark.geometry import from_dlt, triangulate, undistort
from kinemark.io.easywand import read_easywand
from kinemark.io.mat5 import read_mat5
from support.shared import shared_data


def saved(path, compress):
    values = {
        "easy": {"a": np.arange(6.0).reshape(2, 3), "small": np.uint8([1, 2, 3]), "text": "wand", "none": np.zeros(0)},
        "cells": np.array([1.5, "two"], object),
        "flag": np.array([[True, False]]),
        "single": np.float32([[1.25]]),
    }  # fmt: skip
    savemat(path, values, do_compression=compress)
    return path


@pytest.mark.parametrize("compress", [False, True])
def test_mat_files_come_back(tmp_path, compress):
    read = read_mat5(saved(tmp_path / "a.mat", compress))
    np.testing.assert_array_equal(read["easy"]["a"], np.arange(6.0).reshape(2, 3))
    np.testing.assert_array_equal(read["easy"]["small"], [[1, 2, 3]])
    assert read["easy"]["text"] == "wand" and read["easy"]["none"].size == 0
    assert read["cells"][1] == "two" and read["cells"][0] == 1.5
    assert read["single"] == 1.25 and read["flag"].tolist() == [[1.0, 0.0]]


def element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def nested(depth):
    """Cells within cells: other readers follow them until the process dies."""
    value, name = element(14, b""), b""
    for _ in range(depth):
        parts = element(6, struct.pack("<II", 1, 0)) + element(5, struct.pack("<ii", 1, 1)) + element(1, name)
        value = element(14, parts + value)
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM" + value


@pytest.mark.parametrize("compress", [False, True])
def test_damaged_mat_files_are_refused_or_read(tmp_path, compress):
    whole = saved(tmp_path / "a.mat", compress).read_bytes()
    rng = np.random.default_rng(0)
    damaged = [whole[:n] for n in range(1, len(whole), 7)]
    for _ in range(300):
        data = bytearray(whole)
        for at in rng.integers(124, len(data), 3):
            data[at] = rng.integers(256)
        damaged.append(bytes(data))
    refused = 0
    for data in [*damaged, nested(2000), nested(17)]:
        (tmp_path / "b.mat").write_bytes(data)
        try:
            assert isinstance(read_mat5(tmp_path / "b.mat"), dict)
        except KinemarkError:
            refused += 1
    assert refused > 50


def test_deep_and_foreign_files_are_refused(tmp_path):
    for data, words in ((nested(2000), "nested"), (b"x" * 300, "version 5 to 7"), (b"x", "version")):
        (tmp_path / "a.mat").write_bytes(data)
        with pytest.raises(KinemarkError, match=words):
            read_mat5(tmp_path / "a.mat")
    saved(tmp_path / "a.mat", True)
    with pytest.raises(KinemarkError, match="no structure easyWandData"):
        read_easywand(tmp_path / "a.mat")
    savemat(tmp_path / "a.mat", {"easyWandData": {"imageWidth": [640, 640], "imageHeight": [480]}})
    with pytest.raises(KinemarkError, match="imageHeight is 1 numbers, wanted 2"):
        read_easywand(tmp_path / "a.mat")


REAL = {
    "dltdv_thermal_3cam/round3_2018-07-28_easyWandData.mat": (660.0, 80, 6.27),
    "dltdv_bats_4cam/windtunnelCalibration1_extrinsicCalib_20230228_easyWandData.mat": (289.6, 28, 1.61),
    "dltdv_bats_4cam/windtunnelCalibration2_extrinsicCalib_20230228_easyWandData.mat": (289.6, 24, 0.71),
}


@pytest.mark.parametrize("name", REAL)
def test_real_wands_have_their_length(name):
    easy = read_easywand(shared_data(f"cameras/{name}"))
    length, frames, sd = REAL[name]
    assert easy.length == pytest.approx(length)
    ideal = np.stack([undistort(lens, uv) for lens, uv in zip(easy.lenses, easy.wand, strict=True)], 2)
    xyz = triangulate(ideal.reshape(-1, len(easy.sizes), 2), from_dlt(easy.dlt)).reshape(-1, 2, 3)
    came = np.linalg.norm(xyz[:, 1] - xyz[:, 0], axis=1)
    came = came[np.isfinite(came)]
    assert len(came) == frames
    assert came.mean() == pytest.approx(length, abs=0.3) and came.std(ddof=1) == pytest.approx(sd, abs=0.01)
