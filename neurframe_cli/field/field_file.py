"""Fields that can be asked at any point of the input's space, and their file, field.safetensors."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.field.checkpoint import read_safetensors
from neurframe_cli.field.energy_terms import Normalization
from neurframe_cli.field.network import Architecture, FieldNetwork, evaluate
from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.open_file import read_bytes

FORMAT, VERSION = "neurframe-field", 1
# neighbours that a sampled field is interpolated from
NEIGHBORS = 8


@dataclass(frozen=True)
class NeuralField:
    """A trained network and the normalisation of its domain."""

    network: FieldNetwork
    normalization: Normalization

    def query(self, points: Floats) -> Floats:
        """Unit coefficients (n,9) float64 at points (n,3) in input units."""
        device = next(self.network.parameters()).device
        normalized = torch.as_tensor(self.normalization.apply(points), dtype=torch.float32, device=device)
        if not len(points):
            return np.zeros((0, 9))
        return _unit(evaluate(self.network, normalized).double().cpu().numpy())


@dataclass(frozen=True)
class SampledField:
    """The discrete solution without a network: coefficients (m,9) at normalised points (m,3).

    Between the samples it is interpolated by inverse squared distances to the nearest eight (Shepard), so it is
    exact at the centroids that it was solved for.
    """

    points: Floats
    coefficients: Floats
    normalization: Normalization

    def query(self, points: Floats) -> Floats:
        """Unit coefficients (n,9) float64 at points (n,3) in input units."""
        from scipy.spatial import cKDTree

        count = min(NEIGHBORS, len(self.points))
        distances, nearest = cKDTree(self.points).query(
            self.normalization.apply(points), k=[*range(1, count + 1)]
        )
        weights = 1.0 / np.maximum(distances, 1e-12) ** 2
        return _unit(np.einsum("nk,nkc->nc", weights, self.coefficients[nearest]))


Field = NeuralField | SampledField


def field_to_bytes(field: Field, about: dict[str, Any] | None = None) -> bytes:
    """The content of field.safetensors; about: JSON values for whoever reads the file later."""
    from safetensors.torch import save

    center, scale = field.normalization.center.tolist(), field.normalization.scale
    document: dict[str, Any] = {"format": FORMAT, "version": VERSION, "about": about or {}}
    document["normalization"] = {"center": center, "scale": scale}
    if isinstance(field, NeuralField):
        document |= {"kind": "network", "architecture": asdict(field.network.architecture)}
        tensors = {n: t.cpu().contiguous() for n, t in field.network.state_dict().items()}
    else:
        document["kind"] = "samples"
        tensors = {
            "points": torch.from_numpy(field.points),
            "coefficients": torch.from_numpy(field.coefficients),
        }
    return bytes(save(tensors, {"neurframe": json.dumps(document, sort_keys=True)}))


def field_from_bytes(content: bytes, name: str = "field.safetensors") -> Field:
    """Raises UnreadableFile or TooNewFile."""
    tensors, document = read_safetensors(content, name, FORMAT, VERSION)
    try:
        stored = document["normalization"]
        normalization = Normalization(np.array(stored["center"], np.float64), float(stored["scale"]))
        if document["kind"] == "network":
            return NeuralField(_network(document["architecture"], tensors), normalization)
        points, coefficients = (tensors[n].double().numpy() for n in ("points", "coefficients"))
        return _sampled(points, coefficients, normalization)
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise UnreadableFile(f"{name}: the field in it is incomplete: {error}") from error


def read_field(path: Path) -> Field:
    """The field of a file; raises UnreadableFile or TooNewFile."""
    return field_from_bytes(read_bytes(path), str(path))


def _network(architecture: dict[str, Any], tensors: dict[str, torch.Tensor]) -> FieldNetwork:
    network = FieldNetwork(Architecture(**architecture))
    network.load_state_dict(tensors)
    return network.eval()


def _sampled(points: Floats, coefficients: Floats, normalization: Normalization) -> SampledField:
    if points.ndim != 2 or points.shape[1:] != (3,) or coefficients.shape != (len(points), 9):
        raise ValueError(f"points {points.shape} and coefficients {coefficients.shape} do not fit")
    return SampledField(points, coefficients, normalization)


def _unit(q: Floats) -> Floats:
    return np.asarray(q / np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-30))
