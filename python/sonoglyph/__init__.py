"""Drives of an ultrasound phased array for focal points, shapes and letters, and the resulting field.

    import sonoglyph as sg

    scene = sg.Scene(targets=[sg.Text("HIT", at=(0, 0, 0.1), height=0.04)])
    solution = scene.solve()
    pressure = solution.field("rms", (512, 512))    # Pa, float32, shape (512, 512), row 0 at the smallest y

All values are in SI units: metres, seconds, hertz, pascals, radians. Long computations release the GIL, respond to
Ctrl-C and report their progress (0 to 1) to a function given as `progress`.
"""

from ._native import FieldError, GpuError, Map, Motion, Scene, SceneError, Solution, evaluators
from .bench import bench
from .tables import (
    Array,
    Bead,
    Board,
    Body,
    Circle,
    Direction,
    Keyframe,
    Line,
    Liquid,
    Listener,
    Medium,
    Modulation,
    MotionPath,
    Path,
    Picture,
    Plane,
    Point,
    Polygon,
    Quiet,
    Rectangle,
    Reflector,
    Skin,
    Solver,
    Spread,
    Text,
    Tone,
    Trap,
    Triangle,
)

__all__ = [
    "Array",
    "Bead",
    "Board",
    "Body",
    "Circle",
    "Direction",
    "FieldError",
    "GpuError",
    "Keyframe",
    "Line",
    "Liquid",
    "Listener",
    "Map",
    "Medium",
    "Modulation",
    "Motion",
    "MotionPath",
    "Path",
    "Picture",
    "Plane",
    "Point",
    "Polygon",
    "Quiet",
    "Rectangle",
    "Reflector",
    "Scene",
    "SceneError",
    "Skin",
    "Solution",
    "Solver",
    "Spread",
    "Text",
    "Tone",
    "Trap",
    "Triangle",
    "bench",
    "evaluators",
]
