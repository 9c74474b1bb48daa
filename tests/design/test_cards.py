"""Materials and transducers from a file of one's own."""

import pytest

from vibrissa.design.materials import MATERIALS, material
from vibrissa.errors import ArgumentError
from vibrissa.sensor import preset

MATERIAL = 'modulus = "3.5 GPa"\nyield_strain = 0.004\ndensity = "1240 kg/m^3"\n'
TRANSDUCER = 'limit = "10 N, 20 N, 100 N*mm"\nresolution = "2 mN, 4 mN, 10 uN*m"\n'


def test_a_material_of_ones_own(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(MATERIAL)
    found = material(str(path))
    assert (found.modulus, found.yield_strain, found.density) == (3.5e9, 0.004, 1240.0)
    assert found.name == "mine" and found.source == str(path)


def test_a_transducer_of_ones_own(tmp_path):
    path = tmp_path / "mine.TOML"
    path.write_text(TRANSDUCER)
    found = preset(str(path))
    assert found.limit == (10.0, 20.0, 0.1) and found.resolution == (0.002, 0.004, 1e-5)
    assert found.noise == found.resolution
    path.write_text(TRANSDUCER + 'noise = "1 mN, 1 mN, 2 uN*m"\nname = "the one in room 5"\n')
    assert preset(str(path)).noise == (0.001, 0.001, 2e-6)
    assert preset(str(path)).name == "the one in room 5"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (MATERIAL.replace("density", "weight"), "density missing; the keys are modulus, "),
        (MATERIAL + "colour = 3\n", "colour is not known"),
        (MATERIAL.replace("GPa", "mm"), "modulus must be a stress"),
        (MATERIAL.replace("0.004", "-1"), "yield_strain of a material must be positive"),
        ("modulus: 3", "a line is name ="),
    ],
)
def test_a_card_that_is_none_is_refused(text, said, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ArgumentError, match=said):
        material(str(path))


def test_a_card_that_is_not_there_or_lacks_a_channel_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="no such file"):
        preset("none.toml")
    path = tmp_path / "mine.toml"
    path.write_text(TRANSDUCER.replace(", 100 N*mm", ""))
    with pytest.raises(ArgumentError, match="limit needs three values"):
        preset(str(path))


def test_printed_materials_stay_elastic_in_the_weakest_direction():
    for name in ("pla-printed", "petg-printed"):
        assert 0.003 < MATERIALS[name].yield_strain < 0.005
