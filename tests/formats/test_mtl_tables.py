"""What each statement of an MTL file is, written down a second time (decision 38)."""

from alight.formats.obj.maps import MAPS


def test_colours_are_decoded_and_numbers_are_not():
    # Pictures of colours are sRGB; what is measured by a picture is linear.
    colours = {"map_kd", "map_ks", "map_ke"}
    numbers = {"map_d", "map_tr", "map_bump", "bump", "norm"}
    physical = {"map_pr", "map_pm", "map_ps", "map_pc", "map_pcr"}
    expected = dict.fromkeys(colours, "color") | dict.fromkeys(numbers | physical, "number")
    assert expected == MAPS
