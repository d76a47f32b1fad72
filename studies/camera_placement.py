"""What is predicted of cameras against what simulated sessions show, and how many cameras bring how much.

First, volumes, cameras, lenses, markers and noise drawn at random, half of the rigs planned and half plain rings: the
predicted error and coverage of a walking body's markers beside those of a simulated session that is tracked (images
nearer than a marker's diameter run together). Then the systematic analysis of the number of cameras that KISS (2001,
section 6) says is still to be done, for the volume of KISS: planned cameras and rings, heights, arcs and focal lengths.

Run: python studies/camera_placement.py [sessions, 12] [--seed N, 100]
"""

from __future__ import annotations

import argparse

import numpy as np

from kinemark.data import Rig
from kinemark.planning import Planning, Prediction, Room, Sensor, plan_cameras, predict, walks
from kinemark.synth import VOLUME, observe, ring
from kinemark.synth.score import score
from kinemark.track.simultaneous import track_detections

DIAMETER = 14.0
FRAMES = 160


def session(rig: Rig, room: Room, diameter: float, noise: float, seed: int) -> tuple[float, float, float]:
    """Error in 3D (mm), share found of the samples, and ghosts a frame, of both passages."""
    errors, found, ghosts = [], [], []
    for body in walks(room, diameter_mm=diameter, frames=FRAMES):
        away = [np.linalg.norm(body.xyz - camera.centre, axis=-1) for camera in rig]
        across = float(np.nanmedian([c.K[0, 0] * diameter / d for c, d in zip(rig, away, strict=True)]))
        seen = observe(rig, body, noise_px=noise, merge_px=across, seed=seed)
        result = score(track_detections(seen.detections, rig), body.xyz)
        errors.append(result.rmse)
        found.append(result.recall)
        ghosts.append(result.extra_per_frame)
    return float(np.sqrt(np.mean(np.square(errors)))), float(np.mean(found)), float(np.mean(ghosts))


def predicted(rig: Rig, room: Room, diameter: float, noise: float) -> Prediction:
    return predict(rig, room, walks(room, diameter_mm=diameter), diameter_mm=diameter, least_px=2.5, centroid_sd=noise)


def rms(prediction: Prediction) -> float:
    """Predicted error in 3D of what two cameras measure on the body, mm."""
    assert prediction.body is not None
    return float(np.sqrt(3 * np.nanmean(prediction.body.sd**2)))


def at_random(rng: np.random.Generator) -> tuple[str, Rig, Room, float, float]:
    """A rig for a volume: planned, or a ring."""
    volume = np.array([[0, 0, 0], [rng.uniform(1500, 4000), rng.uniform(1000, 2500), rng.uniform(1200, 2200)]])
    room, n, focal = Room(volume), int(rng.integers(3, 9)), float(rng.uniform(900, 1800))
    diameter, noise = float(rng.choice([10, 14, 25])), float(rng.choice([0.05, 0.1, 0.3]))
    if rng.random() < 0.5:
        plan = plan_cameras(room, Sensor(focal), Planning(n, diameter, noise))
        return "planned", plan.rig, room, diameter, noise
    x, y, _ = volume.mean(0)
    around = ring(
        n, radius=float(rng.uniform(3000, 5000)), height=tuple(rng.uniform(800, 2800, 2)), target=(x, y, 850.0),
        sweep_deg=float(rng.choice([180, 270, 360])), start_deg=float(rng.uniform(0, 90)), focal_px=focal,
        volume=volume,
    )  # fmt: skip
    return "ring", around, room, diameter, noise


def foretold(sessions: int, seed: int) -> None:
    print("Error in 3D (mm) and share of samples, predicted and in a simulated session\n")
    print("rig       cameras  volume (m)       marker  focal  noise   predicted  shown  ratio   two or more  found")
    ratios = []
    for k in range(sessions):
        kind, rig, room, diameter, noise = at_random(np.random.default_rng(seed + k))
        said = predicted(rig, room, diameter, noise)
        assert said.body is not None
        shown, found, _ = session(rig, room, diameter, noise, seed + k)
        ratios.append(rms(said) / shown)
        size = " × ".join(f"{x / 1000:.1f}" for x in room.volume[1])
        print(
            f"{kind:9s} {len(rig):7d}  {size:15s} {diameter:4.0f} mm {rig[0].K[0, 0]:6.0f} {noise:6.2f} "
            f"{rms(said):10.3f} {shown:7.3f} {ratios[-1]:6.2f} {100 * said.body.share(2):11.1f} {100 * found:7.1f}"
        )
    within = np.mean(np.abs(np.array(ratios) - 1) <= 0.15)
    print(f"\nratio {min(ratios):.2f} to {max(ratios):.2f}, within 15 % in {100 * within:.0f} % of the sessions\n")


def systematic(seed: int) -> None:
    """For the volume of KISS: 14 mm markers, 0.1 px, 1280 × 1024 px."""
    room = Room(VOLUME)
    print("KISS's volume of 2.4 × 1.4 × 2 m: a walking body's markers (%), error (mm) and ghosts a frame, simulated\n")
    print("cameras                                   two or more  three  predicted  shown  found  ghosts")
    for n in (2, 3, 4, 5, 6, 8, 10):
        row(f"{n} planned", plan_cameras(room, Sensor(), Planning(n, DIAMETER)).rig, room, seed)
    for n in (3, 4, 6, 8):
        row(f"{n} in a ring, 1.1 and 2.3 m high", ring(n), room, seed)
    for low, high in ((600.0, 600.0), (1500.0, 1500.0), (2500.0, 2500.0), (600.0, 2500.0)):
        row(f"6 in a ring, {low / 1000:.1f} and {high / 1000:.1f} m high", ring(6, height=(low, high)), room, seed)
    for arc in (90.0, 150.0, 240.0):
        row(f"6 on an arc of {arc:.0f}°", ring(6, sweep_deg=arc), room, seed)
    for focal in (900.0, 1100.0, 1800.0, 2600.0):
        row(f"6 in a ring, focal length {focal:.0f} px", ring(6, focal_px=focal), room, seed)
    for radius in (3000.0, 6000.0):
        row(f"6 in a ring of {radius / 1000:.0f} m", ring(6, radius=radius), room, seed)


def row(name: str, rig: Rig, room: Room, seed: int) -> None:
    said = predicted(rig, room, DIAMETER, 0.1)
    assert said.body is not None
    shown, found, ghosts = session(rig, room, DIAMETER, 0.1, seed)
    print(
        f"{name:42s} {100 * said.body.share(2):10.1f} {100 * said.body.share(3):6.1f} {rms(said):10.3f} {shown:6.3f} "
        f"{100 * found:6.1f} {ghosts:7.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("sessions", type=int, nargs="?", default=12)
    parser.add_argument("--seed", type=int, default=100)
    asked = parser.parse_args()
    foretold(asked.sessions, asked.seed)
    systematic(asked.seed)


if __name__ == "__main__":
    main()
