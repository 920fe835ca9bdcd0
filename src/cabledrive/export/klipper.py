"""Lines for printer firmware from what `cabledrive shaper` found."""

import json
from pathlib import Path
from typing import Any

from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import require_regular

REMEDY = "give the JSON of `cabledrive shaper LOG --json -o FILE`"


def klipper_files(source: Any) -> dict[str, str]:
    """The configuration of Klipper, and the same for Marlin; refused if it is no answer of `shaper`."""
    place = require_regular(Path(str(source)), REMEDY)
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
        if data["recommended"] is None:
            raise InputRefused(f"recommends no shaper: {data['recommended_reason']}").at(str(place))
        type_, best = str(data["recommended"]), data["recommended_shaper"]
        hertz, damping = float(best["frequency_hz"]), float(data["damping"])
        axis, lines = data["axis"], str(data["configuration"])
    except InputRefused:
        raise
    except OSError as error:
        raise InputRefused(f"cannot be read ({error.strerror}): {REMEDY}").at(str(place)) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputRefused(f"is no answer of shaper ({type(error).__name__}: {error}): {REMEDY}").at(
            str(place)
        ) from None
    if not isinstance(axis, str):
        raise InputRefused("names no axis: run shaper again with --axis x, y or z").at(str(place))
    note = "" if type_.upper() == "ZV" else f" ; Marlin has ZV alone: the type {type_} was recommended"
    return {
        "printer.cfg": lines + "\n",
        "marlin.gcode": f"M593 {axis.upper()} F{hertz:.1f} D{damping:.3g}{note}\n",
    }
