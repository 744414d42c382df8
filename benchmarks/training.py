"""Training, measured as ratios within one run.

    python benchmarks/training.py iteration     # one full-batch iteration against a naive loop of the paper
    python benchmarks/training.py quality       # CPU seconds of the fast preset against the paper's to the same loss
    python benchmarks/training.py throughput    # milliseconds a full-batch iteration beside the arithmetic floor

The mesh is a bent bar made here, or with --model a file of tets.  --device cuda runs the same on a GPU.  Times are CPU
seconds of the process on the CPU, wall seconds with synchronisation on a GPU.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch

from neurframe_cli.field.device import choose_device
from neurframe_cli.field.energy_terms import EnergyTerms, LossWeights, energy_terms
from neurframe_cli.field.network import Architecture, FieldNetwork
from neurframe_cli.field.objectives import FullLoss
from neurframe_cli.field.optimizers import Adam
from neurframe_cli.field.spherical_harmonics import ALIGNED, rotation_band4
from neurframe_cli.mesh.arrays import Features, Floats, TetMesh
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.read_tets import read_tets
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.train import TrainOptions, train

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from train_shapes import box_mesh

# multiply-adds of the network per point, forward and backward (three products per layer), times two
FLOPS_PER_POINT = 6 * (3 * 256 + 4 * 256 * 256 + 256 * 9)


class NaiveLoss:
    """The paper's loop as it reads: f at both ends of every dual edge by gathering four neighbours per tet after
    evaluating them, a 9x9 rotation per alignment term, everything left to autograd."""

    def __init__(self, terms: EnergyTerms, tets: TetMesh, device: str) -> None:
        to = {"dtype": torch.float32, "device": device}
        points = terms.points
        neighbors = tet_adjacency(tets.T).neighbors
        self.exists = torch.as_tensor(neighbors >= 0, device=device)
        around = np.where((neighbors >= 0)[:, :, None], points[neighbors], points[:, None])
        self.points, self.around = torch.as_tensor(points, **to), torch.as_tensor(around, **to)
        distance = np.linalg.norm(around - points[:, None], axis=2)
        self.weights = torch.as_tensor(1.0 / (distance + 1e-2), **to)
        self.rotations = torch.as_tensor(_rotations_to_z(tets), **to)
        self.boundary = torch.as_tensor(terms.boundary.tets, device=device)

    def backpropagate(self, network: FieldNetwork) -> float:
        network.zero_grad()
        q = network(self.points)
        others = torch.stack([network(self.around[:, k]) for k in range(4)], dim=1)
        squared = ((q[:, None] - others) ** 2).sum(dim=2) * self.weights * self.exists
        rotated = torch.bmm(self.rotations, q[self.boundary][:, :, None])[:, 4, 0]
        loss = squared.sum() / self.exists.sum() + 20 * ((ALIGNED - rotated) ** 2).mean()
        loss.backward()
        return float(loss.detach())


def _rotations_to_z(tets: TetMesh) -> Floats:
    """R(n->z) on coefficients (b,9,9) for the normals of the boundary faces."""
    faces = tets.V[tet_adjacency(tets.T).boundary_faces]
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    z = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    helper = np.eye(3)[np.abs(z).argmin(axis=1)]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return rotation_band4(np.stack([x, np.cross(z, x), z], axis=1))


def seconds_of(work: Callable[[], Any], repeats: int, device: str) -> float:
    """Median seconds of one call after a warm-up."""
    clock = time.process_time if device == "cpu" else time.perf_counter
    work()
    times = []
    for _ in range(repeats):
        _synchronize(device)
        start = clock()
        work()
        _synchronize(device)
        times.append(clock() - start)
    return float(np.median(times))


def _synchronize(device: str) -> None:
    if device == "cuda":
        torch.cuda.synchronize()


def iteration(arguments: argparse.Namespace) -> dict[str, Any]:
    """Milliseconds of an iteration: the naive loop, ours in float32, ours in the default precision."""
    tets, _ = _mesh(arguments, 8000)
    device = choose_device(arguments.device, "auto")
    terms = energy_terms(tets, Features(), LossWeights())
    naive, ours = NaiveLoss(terms, tets, device.name), FullLoss(terms, device.name)
    network = FieldNetwork(Architecture(), torch.Generator().manual_seed(0)).to(device.name)
    adam = Adam(list(network.parameters()))

    def step(backpropagate: Callable[[], float]) -> Callable[[], None]:
        def one() -> None:
            backpropagate()
            adam.step(5e-5)

        return one

    times = {"naive": seconds_of(step(lambda: naive.backpropagate(network)), arguments.repeats, device.name)}
    for name, dtype in (("float32", torch.float32), (str(device.hidden_dtype)[6:], device.hidden_dtype)):
        network.hidden_dtype = dtype
        times[name] = seconds_of(step(lambda: ours.backpropagate(network, 0)), arguments.repeats, device.name)
    ratios = {f"naive / {name}": times["naive"] / t for name, t in times.items() if name != "naive"}
    milliseconds = {name: 1e3 * t for name, t in times.items()}
    return {"tets": len(tets.T), "device": device.label, "milliseconds": milliseconds, **ratios}


def quality(arguments: argparse.Namespace) -> dict[str, Any]:
    """CPU seconds of `fast`, and of `paper` until it has the same loss (or until --limit seconds: then a bound)."""
    tets, features = _mesh(arguments, 8000)
    fast = train(tets, features, TrainOptions(device=arguments.device, threads=arguments.threads)).report
    goal, reached = fast["losses"]["total"], []
    start = time.process_time()

    def watch(record: dict[str, Any]) -> None:
        if record["event"] == "step":
            reached.append((time.process_time() - start, record["step"], record["value"]))
            if record["step"] % 100 == 0:
                print(json.dumps({"goal": goal, **record}), file=sys.stderr)
            if record["value"] <= goal or reached[-1][0] > arguments.limit:
                raise _EnoughError

    try:
        options = TrainOptions(
            preset="paper", device=arguments.device, precision=arguments.precision, threads=arguments.threads
        )
        train(tets, features, options, log=watch)
    except _EnoughError:
        pass
    seconds, step, value = reached[-1]
    names = {
        "fast_loss": goal,
        "discrete_floor": fast["discrete_floor"],
        "fast_cpu_seconds": fast["cpu_seconds"],
    }
    paper = {"paper_loss": value, "paper_iterations": step, "paper_cpu_seconds": seconds}
    return {
        "tets": len(tets.T),
        **names,
        **paper,
        "ratio": seconds / fast["cpu_seconds"],
        "met": value <= goal,
    }


class _EnoughError(Exception):
    """The paper's preset has reached the goal or its limit."""


def throughput(arguments: argparse.Namespace) -> dict[str, Any]:
    """Milliseconds a full-batch iteration of the paper's preset, beside products alone at the measured peak rate."""
    rows = []
    for tet_count in arguments.tets or [8000, 50_000]:
        terms = energy_terms(*_mesh(arguments, tet_count), LossWeights())
        for precision in ("fp32", "bf16"):
            device = choose_device(arguments.device, precision)
            network = FieldNetwork(Architecture(), torch.Generator().manual_seed(0)).to(device.name)
            network.hidden_dtype = device.hidden_dtype
            loss, adam = FullLoss(terms, device.name), Adam(list(network.parameters()))

            def step(loss: FullLoss = loss, network: FieldNetwork = network, adam: Adam = adam) -> None:
                loss.backpropagate(network, 0)
                adam.step(5e-5)

            taken = seconds_of(step, arguments.repeats, device.name)
            floor = len(terms.points) * FLOPS_PER_POINT / _peak_rate(device.name, device.hidden_dtype)
            rows.append(
                {
                    "tets": len(terms.points),
                    "precision": precision,
                    "ms": 1e3 * taken,
                    "floor_ms": 1e3 * floor,
                }
            )
    return {"device": choose_device(arguments.device, "fp32").label, "rows": rows}


def _peak_rate(device: str, dtype: torch.dtype) -> float:
    """Floating-point operations per second of products (4096,256) x (256,256), what the network is made of."""
    rows = 4096 if device == "cpu" else 1 << 17
    a, b = (
        torch.randn(rows, 256, device=device, dtype=dtype),
        torch.randn(256, 256, device=device, dtype=dtype),
    )
    return 2.0 * rows * 256 * 256 / seconds_of(lambda: a @ b, 20, device)


def _mesh(arguments: argparse.Namespace, count: int) -> tuple[TetMesh, Features]:
    """The model with its feature edges above 45 degrees, or the bent bar, which is all smooth to the loss."""
    if not arguments.model:
        return box_mesh(round((count / 9.0) ** (1 / 3)), bend=1.2), Features()
    tets, _ = read_tets(Path(arguments.model))
    return tets, features_by_angle(tets.V, tet_adjacency(tets.T).boundary_faces, 45.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["iteration", "quality", "throughput"])
    parser.add_argument("--model", help="a tet mesh")
    parser.add_argument("--tets", type=int, nargs="*", help="tet counts of throughput")
    parser.add_argument("--device", default="auto")
    parser.add_argument("--precision", default="fp32", help="of the paper preset")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--limit", type=float, default=480.0, help="CPU seconds for the paper preset")
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    print(json.dumps(globals()[arguments.what](arguments), indent=1))


if __name__ == "__main__":
    main()
