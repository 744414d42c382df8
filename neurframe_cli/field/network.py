"""The neural field: a SIREN from normalised points to unit band-4 coefficients (paper, sections 4.1 and 5.1).

Sitzmann et al., "Implicit Neural Representations with Periodic Activation Functions" (2020): layers
sin(omega (W x + b)), first weights uniform in +-1/3, all others in +-sqrt(6/256)/omega.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch


@dataclass(frozen=True)
class Architecture:
    """3 -> width, hidden times width -> width, width -> 9; omega is the factor inside every sine.

    The paper's network is the default: four hidden layers of 256 units, 266,505 parameters.
    """

    width: int = 256
    hidden: int = 4
    omega_first: float = 30.0
    omega_hidden: float = 30.0


class FieldNetwork(torch.nn.Module):
    """f(p; Theta): points (n,3) float32 in [-1, 1]^3 -> unit coefficients (n,9) float32."""

    def __init__(self, architecture: Architecture, generator: torch.Generator | None = None) -> None:
        """Initialised from the generator, or with zeros where weights are loaded afterwards."""
        super().__init__()
        self.architecture = architecture
        width = architecture.width
        self.first = torch.nn.Linear(3, width)
        self.hidden = torch.nn.ModuleList(torch.nn.Linear(width, width) for _ in range(architecture.hidden))
        self.last = torch.nn.Linear(width, 9)
        # bf16 here means bf16 operands and results in the hidden layers only; parameters stay float32
        self.hidden_dtype = torch.float32
        self._initialize(generator)

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        omega, dtype = self.architecture.omega_hidden, self.hidden_dtype
        x = torch.sin(self.architecture.omega_first * self.first(points)).to(dtype)
        for layer in self.hidden_layers():
            # omega goes into the small weights instead of the large activations: two passes less
            x = torch.sin(
                torch.nn.functional.linear(
                    x, (omega * layer.weight).to(dtype), (omega * layer.bias).to(dtype)
                )
            )
        return torch.nn.functional.normalize(self.last(x.float()), dim=1)

    def hidden_layers(self) -> list[torch.nn.Linear]:
        return [layer for layer in self.hidden if isinstance(layer, torch.nn.Linear)]

    def hidden_matrices(self) -> list[torch.Tensor]:
        """The square weight matrices."""
        return [layer.weight for layer in self.hidden_layers()]

    def other_parameters(self) -> list[torch.nn.Parameter]:
        """Everything but the square matrices, in a fixed order."""
        matrices = {id(matrix) for matrix in self.hidden_matrices()}
        return [parameter for parameter in self.parameters() if id(parameter) not in matrices]

    def _initialize(self, generator: torch.Generator | None) -> None:
        hidden_bound = math.sqrt(6.0 / self.architecture.width) / self.architecture.omega_hidden
        layers = [
            (self.first, 1.0 / 3.0),
            *((layer, hidden_bound) for layer in [*self.hidden_layers(), self.last]),
        ]
        with torch.no_grad():
            for layer, bound in layers:
                bias_bound = 1.0 / math.sqrt(layer.in_features)
                for tensor, limit in ((layer.weight, bound), (layer.bias, bias_bound)):
                    if generator is None:
                        tensor.zero_()
                    else:
                        tensor.uniform_(-limit, limit, generator=generator)


def evaluate(network: FieldNetwork, points: torch.Tensor, batch: int = 8192) -> torch.Tensor:
    """f at many points (n,3) without gradients, in full float32, in chunks that stay in the cache: (n,9) float32."""
    hidden_dtype, network.hidden_dtype = network.hidden_dtype, torch.float32
    try:
        with torch.no_grad():
            return torch.cat([network(chunk) for chunk in torch.split(points, batch)])
    finally:
        network.hidden_dtype = hidden_dtype
