"""Motion of a painted marker from the frames of a camera, section 4.1, as a log like any other."""

from cabledrive.identification.camera.clip import Clip, clip_of, open_clip
from cabledrive.identification.camera.marker import MarkerTrack, marker_log, scale_from, track_marker

__all__ = ["Clip", "MarkerTrack", "clip_of", "marker_log", "open_clip", "scale_from", "track_marker"]
