"""`cabledrive camera`: the track of a marker in a video, as a log."""

from math import isfinite

import click

from cabledrive.answers.keys import Keys
from cabledrive.app.combinations import refuse_given
from cabledrive.app.options import argument, force_option, opt, subcommand
from cabledrive.app.results import Answer, NewFile, log_csv, provenance
from cabledrive.parameters import InputRefused

CLIP = Keys("text: log count: frames rows number: frame_rate_hz scale map: channels=text texts: findings")


@subcommand('cabledrive camera clip.avi --frame-rate 480 --scale "0.4 mm" -o track.csv', (force_option,))
def command(
    video: str = argument("VIDEO"),
    frame_rate: float | None = opt("Hz", "Of the recording; by default what the file says."),
    scale: float | None = opt("m", "Length of one pixel."),
    known_length: float | None = opt("m", "A length seen in the picture, with --known-pixels."),
    known_pixels: float | None = opt(float, "How many pixels long it is.", metavar="N"),
    markers: int = opt(click.IntRange(1, 2), "How many move.", 1),
    region: str | None = opt("R0:R1,C0:C1", "Rows and columns to look at."),
    output: NewFile = opt(".csv", "The log to write.", required=True, metavar="LOG.csv", flags="-o --output"),
) -> Answer:
    """Follow a white marker through VIDEO, or a folder of pictures, and write a log that `identify` reads."""
    from cabledrive.identification.camera_frames import open_clip
    from cabledrive.identification.camera_marker import marker_log, scale_from, track_marker

    if scale is not None:
        refuse_given("known_length", "known_pixels", why="has no effect beside --scale: give one of the two")
    else:
        if known_length is None or known_pixels is None:
            raise InputRefused("no scale: give --scale, or --known-length with --known-pixels")
        scale = scale_from(known_length, (0.0, 0.0), (known_pixels, 0.0))
    if not (isfinite(scale) and scale > 0.0):
        raise InputRefused(
            f"scale = {scale:.4g} m for one pixel must be finite and above 0: measure it again"
        )
    if not video:
        raise InputRefused("no video is named: give the path of one, or of a folder of pictures")
    track = track_marker(open_clip(video, frame_rate), markers=markers, region=_region(region))
    log = marker_log(track, scale)
    output.write(log_csv(log))
    data = {
        "log": str(output.path),
        "frames": int(track.place.size),
        "rows": len(log),
        "frame_rate_hz": track.frame_rate,
        "scale": scale,
        "channels": {name: log.units[name] for name in log.channels},
        "findings": list(track.findings),
    }
    words = [f"{track.place.size} frames at {track.frame_rate:g} Hz: {', '.join(log.channels)}"]
    words += [f"finding: {finding}" for finding in track.findings]
    return Answer(
        data=data,
        text="\n".join(words),
        provenance=provenance(method="threshold, unwanted spots excluded, centroid in a soft window"),
    )


def _region(text: str | None) -> tuple[int, int, int, int] | None:
    if text is None:
        return None
    try:
        rows, columns = (part.split(":") for part in text.split(","))
        return int(rows[0]), int(rows[1]), int(columns[0]), int(columns[1])
    except (ValueError, IndexError):
        raise InputRefused(f'--region "{text}": write rows and columns, as 10:150,20:200') from None
