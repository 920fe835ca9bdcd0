"""One small log in every format that can be written here."""

import json
import tempfile
from pathlib import Path

import numpy as np

ROWS = 240
TIME = 1e-3 * np.arange(ROWS)
TORQUE, ANGLE = np.sin(40 * TIME), np.cumsum(np.sin(37 * TIME))


def sound_logs(folder):
    """One small log in every format that can be written here."""
    heads, columns = ("time [s]", "torque [N m]", "angle [rad]"), (TIME, TORQUE, ANGLE)
    rows = [",".join(f"{x:.6f}" for x in row) for row in zip(*columns, strict=True)]
    text = "\n".join([",".join(heads), *rows]) + "\n"
    stamps = [f"2026-01-02T03:04:05.{k:03d}," + row.partition(",")[2] for k, row in enumerate(rows)]
    written = {
        "plain.csv": text.encode(),
        "stamps.csv": "\n".join(["# made", ",".join(heads), *stamps]).encode(),
        "comma.csv": text.replace(",", ";").replace(".", ",").encode(),
        "white.txt": text.replace(" [", "[").replace("N m", "Nm").replace(",", " ").encode(),
        "wide.tsv": text.replace(",", "\t").encode("utf-16"),
        "scope.csv": ("Model,X,\nRecord Length,240,\n,,\n" + text).encode("cp1252"),
    }
    lines = [f"{1.5625 * k:.1f}" + 3 * f",{1e3 / (1 + (k - 30) ** 2):.3e}" for k in range(129)]
    moved = [f"{0.625e-3 * k:.6f}" + 2 * f",{9810 + 99 * (-1) ** (k // 9):.6f}" for k in range(1200)]
    heads_of_a_test = ("freq,psd_x,psd_y,psd_xyz", "freq,psd_x,psd_y,psd_xyz,shapers:,zv(59.0)")
    written |= {
        "resonances_x.csv": "\n".join([heads_of_a_test[0], *lines]).encode(),
        "calibration_data_y.csv": "\n".join([heads_of_a_test[1], *(f"{x},,0.5" for x in lines)]).encode(),
        "raw_data_x.csv": "\n".join(["#time,accel_x,accel_y", *moved]).encode(),
    }
    for name, content in written.items():
        (folder / name).write_bytes(content)
    _binary(folder, dict(zip(heads, columns, strict=True)))
    return sorted(folder.iterdir())


def _binary(folder, columns):
    import h5py
    import pyarrow as pa
    from pyarrow import parquet
    from scipy import io

    for compression in ("snappy", "zstd"):
        parquet.write_table(pa.table(columns), folder / f"{compression}.parquet", compression=compression)
    plain = {name.partition(" ")[0]: values for name, values in columns.items()}
    io.savemat(folder / "five.mat", plain)
    io.savemat(folder / "packed.mat", {**plain, "rec": {"a": TIME, "gain": 2.0}}, do_compression=True)
    io.savemat(folder / "four.mat", plain, format="4")
    for name, options in (("plain.h5", {}), ("packed.nc", {"chunks": (64,), "compression": "gzip"})):
        with h5py.File(folder / name, "w") as file:
            for channel, values in plain.items():
                file.create_dataset(channel, data=values, **options).attrs["units"] = (
                    "s" if channel == "time" else ""
                )
    with io.netcdf_file(str(folder / "classic.nc"), "w") as file:
        file.createDimension("rows", ROWS)
        for channel, values in plain.items():
            file.createVariable(channel, "d", ("rows",))[:] = values
    _mcap(folder / "json.mcap", plain)
    _bag(folder, plain)


def _mcap(path, columns):
    try:
        from mcap.writer import Writer
    except ImportError:
        return
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(name="s", encoding="jsonschema", data=b"{}")
        topic = writer.register_channel(schema_id=schema, topic="/a", message_encoding="json")
        for row in zip(*columns.values(), strict=True):
            data = json.dumps(dict(zip(columns, row, strict=True))).encode()
            writer.add_message(topic, log_time=round(1e9 * row[0]), publish_time=0, data=data)
        writer.finish()


def _bag(folder, columns):
    try:
        from rosbags.rosbag2 import Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        return
    types = get_typestore(Stores.ROS2_HUMBLE)
    kind = types.types["geometry_msgs/msg/Vector3"]
    with tempfile.TemporaryDirectory() as place:
        with Writer(Path(place) / "bag", version=8) as bag:
            topic = bag.add_connection("/a", kind.__msgtype__, typestore=types)
            for t, x, y in zip(*columns.values(), strict=True):
                data = types.serialize_cdr(kind(x=x, y=y, z=t), kind.__msgtype__)
                bag.write(topic, round(1e9 * t), data)
        next((Path(place) / "bag").glob("*.db3")).rename(folder / "bag.db3")
