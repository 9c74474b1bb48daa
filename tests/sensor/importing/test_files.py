"""Small files, and all that is said and taken of each: a lost line or a wrong sign is seen."""

from pathlib import Path

import pytest
import yaml

from known import Known, result_of
from vibrissa.sensor.importing import Settings, import_recording

# Files and settings, as they are written.
INPUTS = yaml.safe_load(Path(__file__).with_name("inputs.yaml").read_text(encoding="utf-8"))
KNOWN = Known(__file__)


def read(file, settings):
    found = import_recording(file.encode(), Settings.read(**settings))
    return {"said": found.said, "values": found.values, "zeros": found.zeros}


@pytest.mark.parametrize("name", INPUTS)
def test_a_file_is_read_and_told_as_a_whole_or_refused_word_by_word(name):
    # What is read is what is written, in other units.
    KNOWN.check(name, result_of(read, **INPUTS[name]), 1e-9, floor=1e-15)
