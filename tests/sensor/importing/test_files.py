"""Small files, and all that is said and taken of each: a lost line or a wrong sign is seen."""

from pathlib import Path

import pytest
import yaml

from vibrissa.errors import VibrissaError
from vibrissa.sensor.importing import Settings, import_recording

FOLDER = Path(__file__).parent
FILES = yaml.safe_load((FOLDER / "files.yaml").read_text(encoding="utf-8"))
REFUSED = yaml.safe_load((FOLDER / "refused.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_read_and_told_as_a_whole(name):
    known = FILES[name]
    settings = Settings.read(**known["settings"])
    found = import_recording(known["file"].encode(), settings)
    assert list(found.said) == known["said"]
    assert list(found.values) == list(known["values"])
    for channel, values in known["values"].items():
        assert found.values[channel] == pytest.approx(values, rel=1e-9, abs=1e-15, nan_ok=True)
    assert found.zeros.keys() == known.get("zeros", {}).keys()
    for channel, zero in found.zeros.items():
        assert tuple(zero) == pytest.approx(known["zeros"][channel], rel=1e-9)


@pytest.mark.parametrize("name", REFUSED)
def test_a_file_that_is_refused_gets_its_message_word_by_word(name):
    known = REFUSED[name]
    with pytest.raises(VibrissaError) as caught:
        import_recording(known["file"].encode(), Settings.read(**known["settings"]))
    assert str(caught.value) == known["refused"]
