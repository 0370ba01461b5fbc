"""Our steps against those of torch's own optimiser."""

import torch

from videovec.adam import Adam


def test_steps_are_those_of_torch() -> None:
    generator = torch.Generator().manual_seed(3)
    start = [torch.randn(40, 2, generator=generator), torch.randn(7, generator=generator)]
    theirs = [value.clone().requires_grad_() for value in start]
    ours = [value.clone().requires_grad_() for value in start]
    groups = [{"params": [leaf], "lr": rate} for leaf, rate in zip(theirs, (0.3, 0.02), strict=True)]
    reference, adam = torch.optim.Adam(groups, betas=(0.9, 0.99), eps=0.01), Adam(ours, (0.3, 0.02), 0.01)
    for _ in range(25):
        reference.zero_grad()
        adam.forget_gradients()
        for leaves in (theirs, ours):
            (leaves[0] ** 4 - leaves[0]).sum().backward()  # type: ignore[no-untyped-call]
            leaves[1].cos().sum().backward()  # type: ignore[no-untyped-call]
        reference.step()
        adam.step(1.0)
    for one, two in zip(theirs, ours, strict=True):
        torch.testing.assert_close(one, two, rtol=0, atol=1e-6)


def test_a_tensor_whose_rate_is_0_stays() -> None:
    leaf = torch.ones(3, requires_grad=True)
    adam = Adam([leaf], [0.0], 1e-8)
    adam.forget_gradients()
    leaf.sum().backward()  # type: ignore[no-untyped-call]
    adam.step(1.0)
    assert torch.equal(leaf.detach(), torch.ones(3))


def test_a_smaller_share_is_a_shorter_step() -> None:
    leaf = torch.zeros(1, requires_grad=True)
    adam = Adam([leaf], [0.5], 1e-12)
    adam.forget_gradients()
    leaf.sum().backward()  # type: ignore[no-untyped-call]
    adam.step(0.1)
    torch.testing.assert_close(leaf.detach(), torch.tensor([-0.05]))
