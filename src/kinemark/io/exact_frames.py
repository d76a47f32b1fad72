"""Frames of one camera by their numbers: of a video that stays open, of image files, or the fields of either."""

from __future__ import annotations

from ..data import KinemarkError
from .exact_video import ExactVideo
from .images import ImageSource, read_image
from .pixels import Image


class ExactImages:
    """The frames of one camera, by number: of a video, of image files, or the fields of either."""

    def __init__(self, source: ImageSource) -> None:
        """Raises a KinemarkError where it cannot be read."""
        self.source = source
        self._video = ExactVideo(source.paths[0], source.video) if source.video else None

    def frame(self, n: int) -> Image:
        """Frame n, from 0: (H, W), uint8 or uint16.

        Raises:
            KinemarkError: there is none, or it is damaged.
        """
        source = self.source
        if not 0 <= n < source.n_frames:
            raise KinemarkError(f"There are frames 0 to {source.n_frames - 1}, and {n} was asked for.")
        n *= source.every
        whole, field = divmod(n, 2) if source.interlaced else (n, 0)
        image = self._video.frame(whole) if self._video else read_image(source.paths[whole])
        if not source.interlaced:
            return image
        return image[(field + int(source.interlaced == "bottom")) % 2 :: 2]

    def decoded_from(self, n: int) -> int:
        """The first of the frames that have to be decoded for frame n, n itself where that is all."""
        if self._video is None:
            return n
        fields = 2 if self.source.interlaced else 1
        return min(-(-self._video.decoded_from(n * self.source.every // fields) * fields // self.source.every), n)

    def close(self) -> None:
        """It is not asked again."""
        if self._video:
            self._video.close()
