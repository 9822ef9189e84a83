"""Colours for values, made in OKLab so that equal steps of a value look equally large.

OKLab: B. Ottosson, "A perceptual color space for image processing" (2020). The sequential map
rises in lightness; the diverging map has one lightness on both sides at the same distance from
its pale middle, so that it is read right without hue as well.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Linear sRGB to cone responses, and their cube roots to OKLab.
_TO_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
_FROM_LMS = np.linalg.inv(_TO_LMS)
_FROM_LAB = np.linalg.inv(_TO_LAB)

_STEPS = 256


class _Scale(NamedTuple):
    """Lightness at the ends, hue in degrees at the ends, and chroma at its largest."""

    lightness: tuple[float, float]
    hue: tuple[float, float]
    chroma: float


_SEQUENTIAL = _Scale(lightness=(0.28, 0.93), hue=(292.0, 98.0), chroma=0.135)
_DIVERGING = _Scale(lightness=(0.40, 0.95), hue=(256.0, 38.0), chroma=0.145)

TYPE_COLOURS = np.array(
    [
        [0.80, 0.25, 0.16],
        [0.16, 0.34, 0.72],
        [0.94, 0.64, 0.36],
        [0.47, 0.70, 0.90],
        [0.86, 0.86, 0.84],
        [0.30, 0.62, 0.42],
        [0.78, 0.78, 0.34],
        [0.36, 0.66, 0.66],
    ]
)
"""(8, 3) sRGB for the codes of `SURFACE_TYPES`: warm where convex, cool where concave."""

UNKNOWN_COLOUR = np.array([0.55, 0.55, 0.55])
"""(3,) sRGB where there is no value."""


def linear_srgb(lab: np.ndarray) -> np.ndarray:
    """(..., 3) linear sRGB of OKLab (..., 3); outside 0 to 1 where sRGB has no such colour."""
    return (lab @ _FROM_LAB.T) ** 3 @ _FROM_LMS.T


def encoded(linear: np.ndarray) -> np.ndarray:
    """(..., 3) sRGB as it is stored in pictures, clipped to 0 to 1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def sequential() -> np.ndarray:
    """(256, 3) sRGB from dark violet to light yellow, lightness rising evenly."""
    t = np.linspace(0.0, 1.0, _STEPS)
    low, high = _SEQUENTIAL.lightness
    start, end = _SEQUENTIAL.hue
    # The way round over red, where sRGB has room at medium lightness.
    hue = np.radians(start + (end + 360.0 - start) * t)
    return _in_gamut(low + (high - low) * t, np.full(_STEPS, _SEQUENTIAL.chroma), hue)


def diverging() -> np.ndarray:
    """(256, 3) sRGB from blue over near-white to red, the middle for zero."""
    t = np.linspace(-1.0, 1.0, _STEPS)
    dark, light = _DIVERGING.lightness
    cold, warm = np.radians(_DIVERGING.hue)
    away = np.abs(t)
    lightness = light + (dark - light) * away
    # Full chroma is reached before the end, which stays in gamut there.
    chroma = _DIVERGING.chroma * np.minimum(1.0, 1.6 * away) * (1.0 - 0.1 * away)
    # On both sides the same chroma, the largest that both hues can show.
    sides = [_largest_chroma(lightness, chroma, np.full(_STEPS, hue)) for hue in (cold, warm)]
    chroma = np.minimum(*sides)
    return _srgb(lightness, chroma, np.where(t < 0.0, cold, warm))


def coloured(values: np.ndarray, low: float, high: float, colours: np.ndarray) -> np.ndarray:
    """(n, 3) sRGB of values (n,), where `colours` (s, 3) spans `low` to `high`.

    Values beyond the range have the colours of its ends; what is not a number is grey.
    """
    known = np.isfinite(values)
    # All that is above a range without width is beyond it.
    width = high - low if high > low else np.finfo(float).tiny
    with np.errstate(over="ignore"):
        place = np.clip((np.where(known, values, low) - low) / width, 0.0, 1.0)
    row = np.rint(place * (len(colours) - 1)).astype(np.intp)
    return np.where(known[:, None], colours[row], UNKNOWN_COLOUR)


def robust_range(values: np.ndarray, percent: float, signed: bool) -> tuple[float, float]:
    """The range of values (n,) without `percent` at either end.

    A signed range reaches as far below zero as above; an unsigned one begins at zero if it
    nearly does anyway.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return (-1.0, 1.0) if signed else (0.0, 1.0)
    low, high = np.percentile(finite, (percent, 100.0 - percent))
    if signed:
        reach = max(abs(low), abs(high)) or 1.0
        return -float(reach), float(reach)
    if 0.0 <= low < 0.2 * high:
        low = 0.0
    return float(low), float(high if high > low else low + (abs(low) or 1.0))


def distinct(count: int) -> np.ndarray:
    """(count, 3) sRGB that neighbours in the row are told apart by, for numbered things."""
    number = np.arange(count)
    # Steps of the golden angle: no two of the first dozen hues are close.
    hue = np.radians(30.0 + 137.50776 * number)
    lightness = 0.62 + 0.13 * (number % 3 - 1)
    return _in_gamut(lightness, np.full(count, 0.13), hue)


def _in_gamut(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    return _srgb(lightness, _largest_chroma(lightness, chroma, hue), hue)


def _srgb(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    lab = np.column_stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)])
    return encoded(linear_srgb(lab))


def _largest_chroma(lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray) -> np.ndarray:
    """`chroma` (n,), lessened where sRGB cannot show so much of it, by bisection."""
    low, high = np.zeros_like(chroma), chroma.copy()
    for _ in range(24):
        middle = high if _ == 0 else 0.5 * (low + high)
        lab = np.column_stack([lightness, middle * np.cos(hue), middle * np.sin(hue)])
        rgb = linear_srgb(lab)
        fits = ((rgb >= -1e-6) & (rgb <= 1.0 + 1e-6)).all(axis=1)
        low = np.where(fits, middle, low)
        high = np.where(fits, high, middle)
    return low
