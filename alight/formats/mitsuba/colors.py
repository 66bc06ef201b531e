"""Parameters that are colours: numbers, RGB, spectra of every kind -> linear sRGB."""

from __future__ import annotations

import re

import numpy as np

from alight.core.errors import quote
from alight.core.spectra import blackbody, to_linear_srgb
from alight.core.srgb import decode_srgb
from alight.formats.materials.colors import Color, ColorReader, Pairs, Role, checked, reduced
from alight.formats.mitsuba.properties import Properties
from alight.formats.reading.numbers import NotNumbersError, parse_number, parse_numbers
from alight.formats.reading.xml import Element

_PLUGINS = ("uniform", "d65", "blackbody", "regular", "irregular", "srgb")


class Colors(ColorReader[Element]):
    """Reads colours.

    Parameters
    ----------
    report : Report
    reach : Reach
        Finds files with spectra.
    """

    PROBLEMS = (*ColorReader.PROBLEMS, NotNumbersError)

    def _read(self, item: Element, role: Role) -> Color | None:
        element, tag = item, item.tag
        if tag in ("float", "integer"):
            return [parse_number(_value(element))] * 3
        if tag == "rgb":
            return _rgb(element)
        if tag == "srgb":
            return _srgb(_value(element))
        if tag == "blackbody":
            return self._blackbody_of_old(element)
        if tag == "spectrum":
            return self._spectrum(element, role)
        raise NotNumbersError(f"must be a colour (<rgb>, <spectrum>, <float>), got <{tag}>")

    def _spectrum(self, element: Element, role: Role) -> Color | None:
        if element.type:
            return self._plugin(element, role)
        if "filename" in element:
            pairs = self._pairs_of_file(element.attributes["filename"])
            return self._reduced(element, pairs, role)
        text = _value(element)
        if ":" not in text:
            return _uniform(parse_numbers(text, 1)[0], role)
        words = re.sub(r"\s*:\s*", ":", text).replace(",", " ").split()
        return self._reduced(element, _pairs([word.split(":") for word in words]), role)

    def _reduced(self, element: Element, pairs: Pairs, role: Role) -> Color:
        self._tell_error(element, pairs, role)
        return reduced(pairs, role)

    def _plugin(self, element: Element, role: Role) -> Color | None:
        """Read ``<spectrum type="...">``."""
        properties = Properties(element, self.report)
        color = self._color_of_plugin(element, properties, role)
        properties.finish()
        return color

    def _color_of_plugin(self, element: Element, p: Properties, role: Role) -> Color | None:
        kind = element.type
        if kind == "uniform":
            # Unlike a lone number: Mitsuba takes this one as a colour.
            return [p.number("value", 1.0)] * 3
        if kind == "d65":
            inner = p.find("color")
            color = [1.0] * 3 if inner is None else self.read(inner, "reflectance")
            scale = p.number("scale", 1.0)
            return None if color is None else [scale * channel for channel in color]
        if kind == "srgb":
            inner = p.find("color")
            return [1.0] * 3 if inner is None else self.read(inner, role)
        if kind == "blackbody":
            p.ignore("all wavelengths that are seen count", "wavelength_min", "wavelength_max")
            return _hot(p.number("temperature", 5000.0), p.number("scale", 1.0) or 0.0)
        if kind in ("regular", "irregular"):
            return self._reduced(element, _sampled(kind, p), role)
        self.report.unknown(element, "spectrum", element.type, _PLUGINS, "0.5 is taken")
        p.named.clear()
        p.objects.clear()
        return [0.5] * 3

    def _blackbody_of_old(self, element: Element) -> Color:
        if "temperature" not in element:
            raise NotNumbersError("needs the attribute temperature")
        kelvin = element.attributes["temperature"].strip().removesuffix("K").removesuffix("k")
        return _hot(parse_number(kelvin), parse_number(element.attributes.get("scale", "1")))


def _value(element: Element) -> str:
    if "value" not in element:
        raise NotNumbersError("needs the attribute value")
    return element.attributes["value"]


def _rgb(element: Element) -> Color:
    text = _value(element).strip()
    if text.startswith("#"):
        if not element.old:
            raise NotNumbersError(
                f"must be numbers, got {quote(text)} (hexadecimal colours are written as <srgb>)"
            )
        return _hexadecimal(text)
    numbers = parse_numbers(text, 1, 3)
    return numbers * 3 if len(numbers) == 1 else numbers


def _srgb(text: str) -> Color:
    text = text.strip()
    encoded = _hexadecimal(text) if text.startswith("#") else parse_numbers(text, 1, 3)
    encoded = encoded * 3 if len(encoded) == 1 else encoded
    if not all(0.0 <= channel <= 1.0 for channel in encoded):
        raise NotNumbersError(f"must be in [0, 1], got {quote(text)}")
    return [float(channel) for channel in decode_srgb(np.array(encoded))]


def _hexadecimal(text: str) -> Color:
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", text):
        raise NotNumbersError(f"must be # and 6 hexadecimal digits, got {quote(text)}")
    return [int(text[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]


def _uniform(value: float, role: Role) -> Color:
    if role != "light":
        return [value] * 3
    return reduced((np.array([1.0, 1000.0]), np.array([value, value])), role)


def _hot(temperature: float, scale: float) -> Color:
    if not 1.0 <= temperature <= 1e6:
        raise NotNumbersError(f"temperature must be in [1, 1e+06] K, got {temperature:g}")
    wavelengths, values = blackbody(temperature)
    return to_linear_srgb(wavelengths, scale * values, shines=True)


def _sampled(kind: str, p: Properties) -> tuple[np.ndarray, np.ndarray]:
    values = np.array(parse_numbers(p.text("values")))
    if kind == "irregular":
        wavelengths = np.array(parse_numbers(p.text("wavelengths")))
    else:
        low, high = p.number("wavelength_min", 360.0), p.number("wavelength_max", 830.0)
        wavelengths = np.linspace(low, high, len(values))
    if len(values) != len(wavelengths):
        raise NotNumbersError(
            f"must have as many values as wavelengths, got {len(values)} and {len(wavelengths)}"
        )
    return checked(wavelengths, values)


def _pairs(words: list[list[str]]) -> tuple[np.ndarray, np.ndarray]:
    wrong = next((word for word in words if len(word) != 2), None)
    if wrong is not None:
        text = quote(":".join(wrong))
        raise NotNumbersError(f"must hold pairs wavelength:value in nm, got {text}")
    table = np.array([[parse_number(a), parse_number(b)] for a, b in words]).reshape(-1, 2)
    return checked(table[:, 0], table[:, 1])
