"""A session of the feeding motion in the laboratory of UM²AS, which an operator digitises: no answer given yet."""

from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.video import write_video
from support.eating import footage

NAMES = ("ACR1", "ACR2", "ARM3", "ELB4", "WRU5", "WRR6", "MC37", "REF")
REFERENCE = "REF"


def feeding_in(folder, frames, *, cameras=3, confirm=False, rate=30.0, seed=1):
    """A folder with videos, their calibration and `session.toml`; gives it."""
    rig, _, sight, images = footage(frames / rate, seed)
    folder.mkdir(parents=True, exist_ok=True)
    for c in range(cameras):
        write_video(folder / f"cam{c + 1}.mkv", images[c][:frames], rate)
    write_rig_toml(folder / "rig.toml", rig.select(rig.names[:cameras]))
    marks = "\n".join(f"cam{c + 1} = [{sight.uv[c, 7, 0].tolist()}]" for c in range(cameras))
    (folder / "session.toml").write_text(
        f"""# the arm study, recorded in the basement
name = "feeding study"
rate_hz = {rate}
[cameras]
names = {[f"cam{c + 1}" for c in range(cameras)]}
[calibration]
file = "rig.toml"
[calibration.reference_marker]
{marks}
[digitise]
markers = {list(NAMES)}
reference = "{REFERENCE}"
confirm_reference = {str(confirm).lower()}
[[trials]]
name = "feeding"
images = "{{camera}}.mkv"
answers = "answers/{{camera}}.csv"
""",
        "utf-8",
    )
    return folder


def not_set_up(folder):
    """The session as it is before anybody says that the trial is digitised."""
    file = folder / "session.toml"
    head, _, rest = file.read_text("utf-8").partition("[digitise]")
    trial = rest.partition("[[trials]]")[2].replace("answers =", "# answers =")
    file.write_text(f"{head}[[trials]]{trial}", "utf-8")
    return folder
