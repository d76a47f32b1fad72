"""What is said of the EMG of walks."""

from __future__ import annotations

from .template import Words

MUSCLE_WORDS = {
    "emg_smoothed": Words(
        "{trial}: EMG channels are envelopes already, and are drawn as they are: {channels_list}.",
        "Hum and noise cannot be told of them; give the raw EMG where it is there.",
    ),
    "emg_saturated": Words(
        "{trial}: EMG is cut off at its limits, in up to {samples_share} of the samples: {channels_list}.",
        "Lower the gain. Where most samples are cut off, an electrode is loose.",
    ),
    "emg_scale_doubtful": Words(
        "The EMG of {channels_list} is at most {peak_share} of its greatest contraction: one of both recordings has "
        "another unit or gain.",
        "Check the unit in the files, V or mV, and the amplifier's gain; or leave --mvc out.",
    ),
    "emg_hums": Words(
        "{trial}: the mains ({mains:0}) are heard in the EMG of {channels_list}, and taken out.",
        "Check electrodes and cables.",
    ),
    "emg_left_out": Words(
        "{trial}: channels of EMG cannot be drawn. {why} This is so of {channels_list}.",
        "Export the EMG at the rate at which it was recorded.",
    ),
    "emg_without_bursts": Words(
        "{trial}: the EMG of {channels_list} shows no bursts. It is noise alone, or the muscle never rests: nothing "
        "says when it is on.",
        "Check electrodes and cables. Where nobody wore the channel, nothing is lost.",
    ),
    "emg_without_side": Words(
        "{trial}: EMG channels do not say of which side their muscle is: {channels_list}. They are drawn over the "
        "strides of the left foot, in red.",
        "Name them L … or R …, as L Tib Ant. Of right muscles the curves are wrong.",
    ),
}
"""By the kind of what was found."""
