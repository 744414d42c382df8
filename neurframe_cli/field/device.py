"""Where the network runs and in which precision."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from typing import Any

import torch

from neurframe_cli.errors import UsageError

# of a product of 256-wide matrices in bfloat16 against float32; rounding of the operands gives 0.003
WORST_BF16_ERROR = 0.01


@dataclass(frozen=True)
class Device:
    """name: "cpu" or "cuda"; hidden_dtype: of the operands in the hidden layers; label: for people."""

    name: str
    hidden_dtype: torch.dtype
    label: str


def choose_device(device: str, precision: str) -> Device:
    """Resolves device auto | cpu | cuda and precision auto | fp32 | tf32 | bf16; raises UsageError.

    auto is CUDA where there is a GPU, and bfloat16 in the hidden layers where the hardware multiplies it natively
    and a check of its error passes.
    """
    name = _device_name(device)
    if precision == "tf32" and name == "cuda":
        torch.set_float32_matmul_precision("high")
    wants_bf16 = precision == "bf16" or (precision == "auto" and _multiplies_bf16(name))
    hidden_dtype = torch.bfloat16 if wants_bf16 and bf16_error(name) < WORST_BF16_ERROR else torch.float32
    label = torch.cuda.get_device_name() if name == "cuda" else _cpu_name()
    return Device(name, hidden_dtype, label)


def bf16_error(name: str) -> float:
    """Largest error of a bfloat16 product on the device relative to the largest entry of the float32 product."""
    generator = torch.Generator().manual_seed(0)
    a, b = (torch.randn(256, 256, generator=generator).to(name) for _ in range(2))
    exact = a.double() @ b.double()
    rounded = (a.bfloat16() @ b.bfloat16()).double()
    return float((rounded - exact).abs().max() / exact.abs().max())


def _device_name(device: str) -> str:
    if device == "cuda" and not torch.cuda.is_available():
        raise UsageError("--device cuda: PyTorch finds no CUDA device", hint="use --device cpu or auto")
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    return device


def _multiplies_bf16(name: str) -> bool:
    """Whether bfloat16 products are fast: on x86 only with AMX (AVX-512 BF16 alone was not measured)."""
    if name == "cuda":
        return bool(torch.cuda.is_bf16_supported(including_emulation=False))
    return bool(_cpu_capabilities().get("amx_bf16", False))


def _cpu_name() -> str:
    return str(_cpu_capabilities().get("cpu_name") or platform.processor() or platform.machine())


def _cpu_capabilities() -> dict[str, Any]:
    """What PyTorch knows of the processor; older versions do not say, and then bfloat16 is not chosen."""
    capabilities: dict[str, Any] = getattr(torch.cpu, "get_capabilities", dict)()
    return capabilities
