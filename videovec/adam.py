"""Adam on a few tensors, each with its own rate.

torch's own is made for models of many tensors: it loads torch's compiler at its first step, which takes seconds, and
its bookkeeping costs more than the arithmetic on tensors as small as ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

__all__ = ["Adam"]

_MEAN, _SQUARE = 0.9, 0.99
"""How much of the running means of the gradient and of its square is kept at a step."""


@dataclass(slots=True, eq=False)
class Adam:
    """What the optimiser remembers of its tensors, which it changes in place; those whose rate is 0 stay as they are.

    Args:
        leaves: The tensors; their ``grad`` says where they are to go.
        rates: Step of each.
        floor: Gradient below which a value moves less than its rate.

    Source:
        Kingma and Ba 2015, "Adam: a method for stochastic optimization".
    """

    leaves: Sequence[Tensor]
    rates: Sequence[float]
    floor: float
    _means: list[Tensor] = field(init=False)
    _squares: list[Tensor] = field(init=False)
    _steps: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._means = [torch.zeros_like(leaf) for leaf in self.leaves]
        self._squares = [torch.zeros_like(leaf) for leaf in self.leaves]

    def forget_gradients(self) -> None:
        """Set all gradients to 0."""
        for leaf in self.leaves:
            if leaf.grad is None:
                leaf.grad = torch.zeros_like(leaf)
            else:
                leaf.grad.zero_()

    @torch.no_grad()
    def step(self, share: float) -> None:
        """Take a step at a share of the rates."""
        self._steps += 1
        unbiased = 1.0 - _MEAN**self._steps, (1.0 - _SQUARE**self._steps) ** 0.5
        for leaf, rate, mean, square in zip(self.leaves, self.rates, self._means, self._squares, strict=True):
            if rate == 0.0 or leaf.grad is None:
                continue
            mean.lerp_(leaf.grad, 1.0 - _MEAN)
            square.mul_(_SQUARE).addcmul_(leaf.grad, leaf.grad, value=1.0 - _SQUARE)
            size = square.sqrt().div_(unbiased[1]).add_(self.floor)
            leaf.addcdiv_(mean, size, value=-share * rate / unbiased[0])
