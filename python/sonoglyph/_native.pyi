"""The native part, compiled from `python/src`."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Size: TypeAlias = int | tuple[int, int]
_Drive: TypeAlias = Solution | Motion | ArrayLike | os.PathLike[str]
_Progress: TypeAlias = Callable[[float], object]
_Folder: TypeAlias = str | os.PathLike[str]

class SceneError(ValueError):
    """An invalid scene; `key` names the value, as in `target[1].radius`, or is None."""

    key: str | None

class FieldError(ValueError):
    """An invalid map or volume."""

class GpuError(RuntimeError):
    """The GPU is missing, was lost, or refused the work."""

class _Forces(TypedDict):
    gorkov: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]

class Scene:
    """A scene: targets, array, medium, plane, liquid and motion, in SI units. Immutable: `replace` makes a changed copy."""

    def __init__(self, *, folder: _Folder | None = None, **tables: Any) -> None: ...
    @classmethod
    def load(cls, path: _Folder) -> Scene: ...
    @classmethod
    def loads(cls, text: str, folder: _Folder | None = None) -> Scene: ...
    @classmethod
    def from_dict(cls, tables: Mapping[str, Any], folder: _Folder | None = None) -> Scene: ...
    def dumps(self) -> str: ...
    def save(self, path: _Folder) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def replace(self, **tables: Any) -> Scene: ...
    @property
    def positions(self) -> NDArray[np.float64]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def wavelength(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...
    def solve(
        self,
        method: str | None = None,
        *,
        drive: _Drive | None = None,
        search: float | None = None,
        progress: _Progress | None = None,
    ) -> Solution: ...
    def field(
        self,
        quantity: str = "rms",
        size: _Size | None = None,
        drive: _Drive | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> NDArray[np.float32]: ...
    def map(
        self,
        quantity: str = "rms",
        size: _Size | None = None,
        drive: _Drive | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> Map: ...
    def depression(
        self,
        size: _Size | None = None,
        drive: _Drive | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> NDArray[np.float32]: ...
    def volume(
        self,
        counts: tuple[int, int, int],
        quantity: str = "rms",
        box: Sequence[Sequence[float]] | None = None,
        drive: _Drive | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> NDArray[np.float32]: ...
    def pressure(
        self, points: ArrayLike, drive: _Drive | None = None, *, progress: _Progress | None = None
    ) -> NDArray[np.complex128]: ...
    def transfer(self, points: ArrayLike) -> NDArray[np.complex128]: ...
    def force(
        self, points: ArrayLike, drive: _Drive | None = None, *, progress: _Progress | None = None
    ) -> _Forces: ...
    def body_forces(
        self, drive: _Drive | None = None, *, progress: _Progress | None = None
    ) -> list[dict[str, Any]]: ...
    def frames(self, *, progress: _Progress | None = None) -> Motion: ...
    def _repr_png_(self) -> bytes | None: ...

class Solution:
    """The result of `Scene.solve`: the drive and its figures."""

    @property
    def phases(self) -> NDArray[np.float64]: ...
    @property
    def amplitudes(self) -> NDArray[np.float64]: ...
    @property
    def excitations(self) -> NDArray[np.complex128]: ...
    @property
    def foci(self) -> NDArray[np.float64]: ...
    @property
    def targets(self) -> NDArray[np.float64]: ...
    @property
    def pressures(self) -> NDArray[np.complex128]: ...
    @property
    def quality(self) -> dict[str, Any]: ...
    @property
    def nonlinear(self) -> dict[str, Any] | None: ...
    @property
    def bodies(self) -> list[dict[str, Any]]: ...
    @property
    def felt(self) -> dict[str, Any] | None: ...
    @property
    def method(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def scene(self) -> Scene: ...
    def map(
        self,
        quantity: str = "rms",
        size: _Size | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> Map: ...
    def field(
        self,
        quantity: str = "rms",
        size: _Size | None = None,
        *,
        evaluator: str = "auto",
        tolerance: float | None = None,
        progress: _Progress | None = None,
    ) -> NDArray[np.float32]: ...
    def _repr_png_(self) -> bytes: ...

class Map:
    """The values of a quantity on a plane, with peak, error and extent."""

    @property
    def values(self) -> NDArray[np.float32]: ...
    @property
    def quantity(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def peak(self) -> float: ...
    @property
    def error(self) -> float: ...
    @property
    def how(self) -> str: ...
    @property
    def extent(self) -> tuple[float, float, float, float]: ...
    def png(self, colours: str = "inferno") -> bytes: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...
    def _repr_png_(self) -> bytes: ...

class Motion:
    """The drives of all frames of a motion: the result of `Scene.frames`."""

    @property
    def phases(self) -> NDArray[np.float64]: ...
    @property
    def amplitudes(self) -> NDArray[np.float64]: ...
    @property
    def times(self) -> NDArray[np.float64]: ...
    @property
    def foci(self) -> list[NDArray[np.float64]]: ...
    @property
    def pressures(self) -> list[NDArray[np.complex128]]: ...
    @property
    def rate(self) -> float: ...
    @property
    def response(self) -> dict[str, Any] | None: ...
    @property
    def seconds(self) -> float: ...
    def __len__(self) -> int: ...

def evaluators() -> list[tuple[str, str]]:
    """The available evaluators and their hardware."""
