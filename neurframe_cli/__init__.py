"""neurframe: quad and hex meshes from any surface mesh, guided by a learned continuous frame field.

    import neurframe_cli as nf
    result = nf.run(V, F, hex=True, scale=30)
    result.hex.V, result.hex.cells, result.hex.valid

The functions and values are those of neurframe_cli.api; they are loaded when they are first asked for.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from neurframe_cli.api import (
        Frames,
        HexOptions,
        HybridMesh,
        Limits,
        Mesh,
        QuadOptions,
        Result,
        TetizeOptions,
        Tets,
        TrainOptions,
        discretize,
        hex,
        quad,
        run,
        tetize,
        train,
    )

__version__ = "0.1.0"

__all__ = [
    "Frames",
    "HexOptions",
    "HybridMesh",
    "Limits",
    "Mesh",
    "QuadOptions",
    "Result",
    "TetizeOptions",
    "Tets",
    "TrainOptions",
    "__version__",
    "discretize",
    "hex",
    "quad",
    "run",
    "tetize",
    "train",
]


def __getattr__(name: str) -> Any:
    """PEP 562: `import neurframe_cli` alone, as the command line does, loads no numpy."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from neurframe_cli import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return __all__
