"""neurframe: quad and hex meshes from any surface mesh, guided by a learned continuous frame field."""

__version__ = "0.1.0"
