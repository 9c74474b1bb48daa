"""Files as programs of laboratories write them, all of the same small recording."""

import numpy as np
import pytest

from vibrissa.sensor.importing import Settings, import_recording

TIME = np.arange(20) * 0.02
TABLE = np.column_stack([TIME, 1.5 * TIME, -0.3 - TIME, -0.5 + 0.1 * TIME, 20.0 - TIME])

# LabVIEW measurement file: three header blocks, and a title of a column that no row has.
LVM = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t.
X_Columns\tOne
Date\t2026/03/12
Time\t10:12:33.7712
***End_of_Header***\t
\t
Channels\t4\t\t\t\t
Samples\t20\t20\t20\t20\t
Date\t2026/03/12\t2026/03/12\t2026/03/12\t2026/03/12\t
Y_Unit_Label\tmm\tN\tN\tN*mm\t
X0\t0.0E+0\t0.0E+0\t0.0E+0\t0.0E+0\t
Delta_X\t0.020000\t0.020000\t0.020000\t0.020000\t
***End_of_Header***\t\t\t\t\t
X_Value\tStage\tFx\tFz\tMy\tComment
"""
CLOCK = TABLE + np.array([1.7e9, 0.0, 0.0, 0.0, 0.0])
NAMED = {"time": "t", "footpoint": "Stage", "force_x": "Fx", "force_y": "Fz", "moment_z": "My"}


def rows(separator, table=TABLE):
    return "".join(separator.join(f"{cell:.6f}" for cell in row) + "\n" for row in table)


SAMPLES = {
    "LabVIEW": (
        LVM + rows("\t"),
        {
            "time": "X_Value [s]",
            "footpoint": "Stage [mm]",
            "force_x": "Fx [N]",
            "force_y": "Fz [N]",
        },
    ),
    "units in brackets below": ("t;Stage;Fx;Fz;My\n[s];[mm];[N];[N];[Nmm]\n" + rows(";"), NAMED),
    "time stamps of a clock": (
        "timestamp_s,Stage_mm,Fx_N,Fz_N,My_Nmm\n" + rows(",", CLOCK),
        NAMED | {"time": "timestamp"},
    ),
    "quotes everywhere": (
        '"Time (s)","Stage (mm)","Fx (N)","Fz (N)"\n'
        + "\n".join(",".join(f'"{cell:.6f}"' for cell in row[:4]) for row in TABLE),
        {name: NAMED[name] for name in ("footpoint", "force_x", "force_y")},
    ),
}


@pytest.mark.parametrize("name", SAMPLES)
def test_a_file_of_a_laboratory_is_read(name):
    text, columns = SAMPLES[name]
    values = import_recording(text.encode(), Settings.read(column=columns)).values
    assert values["time"] - values["time"][0] == pytest.approx(TIME, abs=1e-6)
    assert values["footpoint"] * 1e3 == pytest.approx(TABLE[:, 1], abs=1e-6)
    assert values["force_x"] == pytest.approx(TABLE[:, 2], abs=1e-6)
    assert values["force_y"] == pytest.approx(TABLE[:, 3], abs=1e-6)
    if "moment_z" in columns:
        assert values["moment_z"] * 1e3 == pytest.approx(TABLE[:, 4], abs=1e-6)
