"""The tables of a scene file as classes: keyword arguments in SI units, with the program's own defaults.

docs/scene.md explains each key, with its default and its limits.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Union

Vector = Sequence[float]
"""x, y, z: a tuple, a list or a NumPy array."""
FileName = Union[str, "os.PathLike[str]"]


class _Table:
    """A table of the scene file: all fields that are not None, `from_` as `from`, and the kind."""

    kind: ClassVar[str | None] = None

    def _table(self) -> dict[str, Any]:
        values = {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        named = {} if self.kind is None else {"kind": self.kind}
        return named | {key: value for key, value in values.items() if value is not None}


@dataclass(kw_only=True)
class Medium(_Table):
    """The air: temperature (°C), humidity (%) and pressure (Pa), or the values derived from them."""

    temperature: float | None = None
    humidity: float | None = None
    pressure: float | None = None
    sound_speed: float | None = None
    """m/s"""
    density: float | None = None
    """kg/m³"""
    absorption: float | None = None
    """dB/m"""


@dataclass(kw_only=True)
class Spread(_Table):
    """Random differences between elements, rms: of the gain (relative), and of the phase (rad)."""

    gain: float | None = None
    phase: float | None = None


@dataclass(kw_only=True)
class Array(_Table):
    """Equal elements in rows and columns, `pitch` (m) apart, or at the positions of an `elements` table."""

    rows: int | None = None
    columns: int | None = None
    pitch: float | None = None
    element_radius: float | None = None
    """m"""
    frequency: float | None = None
    """Hz"""
    strength: float | None = None
    """Pa·m, peak, on axis at full drive"""
    element: str | None = None
    """piston, exact-piston, point, rectangle, cosine or measured"""
    element_size: Sequence[float] | None = None
    """m, width and height of a rectangle"""
    element_exponent: float | None = None
    """of a cosine"""
    directivity: FileName | None = None
    """of a measured element: a CSV file with angle (degrees), amplitude or level (dB), and perhaps phase (degrees)"""
    off: Sequence[int] | None = None
    elements: FileName | None = None
    """a CSV file, or preset:NAME"""
    wiring: FileName | None = None
    """the boards' channels: a CSV file with element,channel, or preset:NAME"""
    reflectivity: float | None = None
    response: Mapping[str, float] | str | None = None
    """of an element: resonance (Hz) and tau (s), or t4010a1"""
    spread: Spread | None = None
    """random differences between elements"""


@dataclass(kw_only=True)
class Board(_Table):
    """A copy of the array: its centre (m), direction of radiation, and direction of increasing column."""

    at: Vector | None = None
    normal: Vector | None = None
    x_axis: Vector | None = None


@dataclass(kw_only=True)
class Reflector(_Table):
    """An infinite reflecting plane: a point (m), the normal towards the sound, and the pressure reflection coefficient."""

    point: Vector | None = None
    normal: Vector | None = None
    coefficient: float | None = None


@dataclass(kw_only=True)
class _Target(_Table):
    pressure: float | None = None
    """relative to the other targets, or Pa (peak) with `Solver(pressures="pascal")`"""
    visible: bool | None = None
    name: str | None = None
    group: str | None = None
    step: int | None = None
    motion: MotionPath | None = None
    """the target's own motion, instead of the scene's"""
    modulation: Modulation | None = None
    """the target's own modulation, instead of the scene's"""


@dataclass(kw_only=True)
class _Drawn(_Target):
    spacing: float | None = None
    """m between separate focal points; without it and `points` the outline is a continuous stroke"""
    points: int | None = None
    """separate focal points on the whole outline"""
    stroke: float | None = None
    """m: width of the outline, as an area"""
    angle: float | None = None
    """rad, about the target's centre"""


@dataclass(kw_only=True)
class _Flat(_Drawn):
    normal: Vector | None = None


@dataclass
class Point(_Target):
    """A focal point; `at` in m."""

    kind: ClassVar[str] = "point"
    at: Vector


@dataclass
class Direction(_Target):
    """A plane wave towards a direction, of any length; its pressure is that at 1 m without absorption."""

    kind: ClassVar[str] = "direction"
    direction: Vector


@dataclass
class Line(_Drawn):
    """A line between two points, m."""

    kind: ClassVar[str] = "line"
    from_: Vector
    to: Vector


@dataclass
class Circle(_Flat):
    """A circle: centre and radius, m."""

    kind: ClassVar[str] = "circle"
    at: Vector
    radius: float
    fill: bool | None = None


@dataclass
class Rectangle(_Flat):
    """A rectangle: centre, width and height, m."""

    kind: ClassVar[str] = "rectangle"
    at: Vector
    width: float
    height: float
    fill: bool | None = None


@dataclass
class Triangle(_Flat):
    """An equilateral triangle: centre and side, m."""

    kind: ClassVar[str] = "triangle"
    at: Vector
    size: float
    fill: bool | None = None


@dataclass
class Polygon(_Flat):
    """A regular polygon: centre, radius (m) and number of sides."""

    kind: ClassVar[str] = "polygon"
    at: Vector
    radius: float
    sides: int
    fill: bool | None = None


@dataclass
class Path(_Drawn):
    """A polyline through vertices, m."""

    kind: ClassVar[str] = "path"
    vertices: Sequence[Vector]
    closed: bool | None = None
    fill: bool | None = None
    pressures: Sequence[float] | None = None
    """one per vertex, times `pressure`"""


@dataclass
class Text(_Flat):
    """A text: its centre and the height of its letters, m."""

    kind: ClassVar[str] = "text"
    text: str
    at: Vector
    height: float


@dataclass
class Picture(_Target):
    """A picture whose grey value prescribes |p|²: a file, its centre and its width, m."""

    kind: ClassVar[str] = "picture"
    file: FileName
    at: Vector
    width: float
    angle: float | None = None
    normal: Vector | None = None


@dataclass
class Trap(_Target):
    """A trap (m) for the scene's bead: twin, vortex, bottle, standing or focus."""

    kind: ClassVar[str] = "trap"
    at: Vector
    trap: str | None = None
    charge: int | None = None
    angle: float | None = None
    normal: Vector | None = None


@dataclass(kw_only=True)
class Quiet(_Table):
    """A quiet zone: circle (`radius`), rectangle (`width`, `height`) or polygon (`radius`, `sides`), m."""

    kind: str | None = None  # type: ignore[misc]
    at: Vector | None = None
    radius: float | None = None
    width: float | None = None
    height: float | None = None
    sides: int | None = None
    weight: float | None = None
    normal: Vector | None = None
    angle: float | None = None


@dataclass(kw_only=True)
class Body(_Table):
    """A solid that scatters the sound: sphere, capsule, palm, hand or mesh (`file`, in units of `scale` m)."""

    kind: str | None = None  # type: ignore[misc]
    at: Vector | None = None
    normal: Vector | None = None
    x_axis: Vector | None = None
    radius: float | None = None
    """m, of a sphere or capsule"""
    length: float | None = None
    """m, of a capsule from end to end"""
    size: Vector | None = None
    """m, of a palm: along x, across, thickness"""
    fingers: Sequence[float] | None = None
    """degrees by which thumb, index, middle, ring and little finger bend"""
    file: FileName | None = None
    """STL or OBJ"""
    scale: float | None = None
    """m per unit of the file"""
    coefficient: float | None = None
    """pressure reflection of its surface: 1 rigid"""
    edge: float | None = None
    """m, of the triangles that stand for its surface"""


@dataclass(kw_only=True)
class Solver(_Table):
    """The solver; `search` is the time (s) of a further search."""

    method: str | None = None
    iterations: int | None = None
    pressures: str | None = None
    """relative or pascal"""
    amplitudes: str | None = None
    """uniform or free"""
    quiet: float | None = None
    search: float | None = None
    frames: int | None = None
    target: str | None = None
    """pressure, depression or felt"""


@dataclass(kw_only=True)
class Plane(_Table):
    """The rectangle on which the field is evaluated: centre and size, m; `tolerance` relative to the map's peak."""

    centre: Vector | None = None
    x_axis: Vector | None = None
    y_axis: Vector | None = None
    size: Sequence[float] | None = None
    tolerance: float | None = None


@dataclass(kw_only=True)
class Liquid(_Table):
    """The liquid whose surface is the scene's plane."""

    name: str | None = None
    density: float | None = None
    """kg/m³"""
    surface_tension: float | None = None
    """N/m"""
    viscosity: float | None = None
    """Pa·s"""
    gravity: float | None = None
    """m/s²"""
    depth: float | None = None
    """m"""
    reflects: bool | None = None
    refractive_index: float | None = None
    light: str | None = None
    """through or reflected"""
    screen: float | None = None
    """m from the level surface"""


@dataclass(kw_only=True)
class Bead(_Table):
    """The levitated sphere; radius in m."""

    material: str | None = None
    density: float | None = None
    """kg/m³"""
    sound_speed: float | None = None
    """m/s"""
    radius: float | None = None


@dataclass(kw_only=True)
class Skin(_Table):
    """The skin of a hand on the plane: a half-space, or a layer on bone; with it solutions say what is felt."""

    wave_speed: float | None = None
    """m/s, of surface waves"""
    viscosity: float | None = None
    """Pa·s"""
    density: float | None = None
    """kg/m³"""
    depth: float | None = None
    """m, of a layer on bone"""
    threshold: FileName | None = None
    """hand, psychohaptic, afferents or a CSV file"""


@dataclass(kw_only=True)
class Tone(_Table):
    """One tone of a modulation: Hz, depth (0 to 1) and phase (rad)."""

    frequency: float | None = None
    depth: float | None = None
    phase: float | None = None


@dataclass(kw_only=True)
class Modulation(_Table):
    """Amplitude modulation: off, sine, square, tones or file."""

    shape: str | None = None
    law: str | None = None
    """amplitude or power"""
    frequency: float | None = None
    """Hz"""
    depth: float | None = None
    tones: Sequence[Tone] | None = None
    file: FileName | None = None


@dataclass(kw_only=True)
class Keyframe(_Table):
    """A keyframe of a motion: time (fraction of the cycle), offset (m), pressure, turn, phase, easing to the next."""

    time: float | None = None
    at: Vector | None = None
    pressure: float | None = None
    angle: float | None = None
    """rad, about the target's normal; 2π is a full turn"""
    phase: float | None = None
    """rad, added to the opposite part of a trap"""
    easing: str | None = None


@dataclass(kw_only=True)
class MotionPath(_Table):
    """The motion of targets: `rate` in cycles per second, or `speed` in m/s; size in m."""

    path: str | None = None
    size: float | None = None
    angle: float | None = None
    rate: float | None = None
    speed: float | None = None
    frames: int | None = None
    points: Sequence[Vector] | None = None
    keyframes: Sequence[Keyframe] | None = None
    file: FileName | None = None
    """CSV of places or G-code, for the path `file`"""
    foci: int | None = None
    lead: bool | None = None
    """ahead of the path by the response time of the elements"""


@dataclass(kw_only=True)
class Listener(_Table):
    """The position of an ear, m."""

    at: Vector
