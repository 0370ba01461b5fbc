"""Training of the network that decides at junctions: the same network as the library's, in torch."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from benchmarks.junction_data import Drawn
from videovec.initialise.arrangement import Arrangement, arrange
from videovec.initialise.junction_features import Features, describe
from videovec.initialise.junction_net import prior
from videovec.initialise.junctions import decisions

__all__ = ["Example", "Net", "accuracy", "prepare", "scores_of", "to_bytes", "train"]

WIDTH, HIDDEN, ROUNDS = 32, 48, 4
"""Size of a state, of the layer between two states, and how often neighbours are heard."""


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """A drawing, or several one after the other, and its junctions whose truth is clear.

    Args:
        features: Numbers of ends, pairs and regions. [E, .], [P, .], [F, .]
        links: Which of them touch: opposite ends [E], ends of pairs [P, 2], sides of branches [E, 2], wedge [E], region
            of the wedge [E] and degree of the node [E], as in ``Arrangement``.
        junctions: For each number of arms K: pairs of every junction [N, K(K-1)/2] and its true matching [N].
    """

    features: tuple[Tensor, Tensor, Tensor]
    links: tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]
    junctions: dict[int, tuple[Tensor, Tensor]]


def _incidence(arms: int) -> Tensor:
    """Which pairs each decision has. [M, K(K-1)/2]"""
    pairs = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(arms) for j in range(i + 1, arms))}
    table = torch.zeros(len(decisions(arms)), len(pairs))
    for row, matching in enumerate(decisions(arms)):
        for i, j in matching:
            table[row, pairs[min(i, j), max(i, j)]] = 1.0
    return table


INCIDENCE = {arms: _incidence(arms) for arms in range(2, 8)}


def prepare(drawn: Drawn) -> Example:
    """Arrays of one drawing."""
    laid = arrange(drawn.graph, drawn.widths)
    features: Features = describe(laid)
    index = {end: number for number, end in enumerate(laid.ends)}
    number = {frozenset(pair): k for k, pair in enumerate(map(tuple, laid.pairs.tolist()))}
    found: dict[int, tuple[list[list[int]], list[int]]] = {}
    for known in drawn.junctions:
        arms = len(known.ends)
        if not known.is_clear or known.links not in decisions(arms):
            continue
        ends = [index[end] for end in known.ends]
        truth = {frozenset(pair) for pair in known.links}
        pairs, right = found.setdefault(arms, ([], []))
        pairs.append([number[frozenset((ends[i], ends[j]))] for i in range(arms) for j in range(i + 1, arms)])
        right.append(next(k for k, m in enumerate(decisions(arms)) if {frozenset(pair) for pair in m} == truth))
    junctions = {arms: (torch.tensor(pairs), torch.tensor(right)) for arms, (pairs, right) in found.items()}
    numbers = (features.ends, features.pairs, features.regions)
    ends_, pairs_, regions_ = (torch.tensor(values, dtype=torch.float32) for values in numbers)
    return Example((ends_, pairs_, regions_), _links(laid), junctions)


def _links(laid: Arrangement) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
    opposite, pairs, sides, wedge, region, degree = (
        torch.tensor(values) for values in (laid.opposite, laid.pairs, laid.sides, laid.wedge, laid.region, laid.degree)
    )
    return opposite, pairs, sides, wedge, region, degree


def together(examples: Sequence[Example]) -> Example:
    """Several drawings as one that has them side by side."""
    before = [np.cumsum([0, *(len(e.features[k]) for e in examples)])[:-1].tolist() for k in range(3)]
    shifted = []
    for example, end, pair, region in zip(examples, *before, strict=True):
        opposite, pairs, sides, wedge, regions, degree = example.links
        wedge = torch.where(wedge < 0, wedge, wedge + pair)
        shifted.append((opposite + end, pairs + end, sides + region, wedge, regions + region, degree))
    junctions = {}
    for arms in INCIDENCE:
        own = [(e.junctions[arms], pair) for e, pair in zip(examples, before[1], strict=True) if arms in e.junctions]
        if own:
            junctions[arms] = torch.cat([x[0] + shift for x, shift in own]), torch.cat([x[1] for x, _ in own])
    ends, pairs_, regions_ = (torch.cat([e.features[k] for e in examples]) for k in range(3))
    one, two, three, four, five, six = (torch.cat([s[k] for s in shifted]) for k in range(6))
    return Example((ends, pairs_, regions_), (one, two, three, four, five, six), junctions)


def _sum(rows: Tensor, owner: Tensor, count: int) -> Tensor:
    return torch.zeros(count, rows.shape[1]).index_add(0, owner, rows)


def _mean(rows: Tensor, owner: Tensor, count: int) -> Tensor:
    return _sum(rows, owner, count) / torch.bincount(owner, minlength=count).clamp(min=1)[:, None]


def _most(rows: Tensor, owner: Tensor, count: int) -> Tensor:
    where = owner[:, None].expand_as(rows)
    return torch.zeros(count, rows.shape[1]).scatter_reduce(0, where, rows, "amax", include_self=True)


def _two_layers(inward: int, hidden: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inward, hidden), nn.ReLU(), nn.Linear(hidden, WIDTH))


class Net(nn.Module):
    """See ``videovec.initialise.junction_net``, which must compute the same."""

    def __init__(self, examples: Sequence[Example]) -> None:
        super().__init__()
        every = [torch.cat([e.features[k] for e in examples]) for k in range(3)]
        self.scale = [(x.mean(dim=0), x.std(dim=0).clamp(min=1e-3)) for x in every]
        ends, pairs, regions = (x.shape[1] for x in every)
        self.end, self.region = nn.Linear(ends, WIDTH), nn.Linear(regions, WIDTH)
        self.pair = _two_layers(pairs + 2 * WIDTH, 2 * WIDTH)
        self.ends = nn.ModuleList(_two_layers(6 * WIDTH, HIDDEN) for _ in range(ROUNDS))
        self.regions = nn.ModuleList(_two_layers(4 * WIDTH, HIDDEN) for _ in range(ROUNDS))
        self.pairs = nn.ModuleList(_two_layers(4 * WIDTH, HIDDEN) for _ in range(ROUNDS))
        self.score = nn.Linear(WIDTH, 1)

    def forward(self, example: Example) -> Tensor:
        """Score of every pair. [P]"""
        opposite, ends_of, sides, wedge, region, degree = example.links
        seen = [((x - m) / s).clamp(-5, 5) for x, (m, s) in zip(example.features, self.scale, strict=True)]
        count, pair_count, region_count = (len(x) for x in seen)
        (one, two), turned = ends_of.T, wedge >= 0
        both, wedge, region = torch.cat([one, two]), wedge[turned], region[turned]
        ends, areas = torch.relu(self.end(seen[0])), torch.relu(self.region(seen[2]))
        pairs = torch.relu(self.pair(torch.cat([seen[1], *_in_any_order(ends[one], ends[two])], dim=1)))
        for end_layer, region_layer, pair_layer in zip(self.ends, self.regions, self.pairs, strict=True):
            heard = torch.cat([pairs, pairs])
            told = torch.cat([_most(heard, both, count), _sum(heard, both, count) / degree[:, None]], dim=1)
            beside = _in_any_order(areas[sides[:, 0]], areas[sides[:, 1]])
            corner = pairs[wedge]
            bounds = _mean(corner, region, region_count), _most(corner, region, region_count)
            along = _mean(ends.repeat_interleave(2, 0), sides.reshape(-1), region_count)
            areas_next = torch.relu(areas + region_layer(torch.cat([areas, *bounds, along], dim=1)))
            ends = torch.relu(ends + end_layer(torch.cat([ends, ends[opposite], told, *beside], dim=1)))
            areas = areas_next
            around = _mean(areas[region], wedge, pair_count)
            pairs = torch.relu(pairs + pair_layer(torch.cat([pairs, *_in_any_order(ends[one], ends[two]), around], 1)))
        return torch.as_tensor(self.score(pairs)[:, 0])


def _in_any_order(one: Tensor, two: Tensor) -> tuple[Tensor, Tensor]:
    return one + two, (one - two).abs()


def _answers(scores: Tensor, example: Example) -> list[tuple[int, Tensor, Tensor]]:
    """Logits of all decisions about the junctions of each number of arms, and the true ones."""
    return [(k, scores[pairs] @ INCIDENCE[k].T, right) for k, (pairs, right) in example.junctions.items()]


def train(examples: list[Example], epochs: int, seed: int, rate: float = 4e-3, batch: int = 24) -> Net:
    """Make the true decision about every junction likely, of all about so many arms.

    Args:
        examples: Drawings to learn from.
        epochs: How often each is seen.
        seed: Of the first weights and the order of drawings.
        rate: Largest learning rate; it rises and falls once.
        batch: Drawings of a step.
    """
    torch.manual_seed(seed)
    net, rng = Net(examples), np.random.default_rng(seed)
    optimiser = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=1e-3)
    steps = len(examples) // batch
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=epochs * steps + 1, pct_start=0.15)
    for _ in range(epochs):
        order = rng.permutation(len(examples))
        for k in range(steps):
            drawn = together([examples[i] for i in order[k * batch : (k + 1) * batch]])
            answers = _answers(net(drawn), drawn)
            losses = [nn.functional.cross_entropy(x, y, reduction="sum") for _, x, y in answers]
            loss = torch.stack(losses).sum() / sum(len(y) for _, _, y in answers)
            optimiser.zero_grad()
            torch.autograd.backward(loss)
            nn.utils.clip_grad_norm_(net.parameters(), 2.0)
            optimiser.step()
            schedule.step()
    return net


@torch.no_grad()
def scores_of(nets: Sequence[Net], example: Example) -> Tensor:
    """What the library makes of several networks. [P]"""
    mean = torch.stack([net(example) for net in nets]).mean(dim=0)
    return mean + torch.as_tensor(prior(example.features[1].numpy()))


def accuracy(nets: Sequence[Net], examples: Sequence[Example]) -> tuple[float, int]:
    """Share of junctions that are wholly right, and how many there are."""
    right = [(x.argmax(dim=1) == y) for e in examples for _, x, y in _answers(scores_of(nets, e), e)]
    return (float(torch.cat(right).float().mean()), sum(map(len, right))) if right else (float("nan"), 0)


def _arrays(net: Net) -> dict[str, Tensor]:
    """The weights under the names that the library reads."""
    arrays = {}
    for kind, (mean, spread) in zip(("end", "pair", "region"), net.scale, strict=True):
        arrays[kind + ".mean"], arrays[kind + ".spread"] = mean, spread
    named: dict[str, nn.Module] = {"end": net.end, "region": net.region, "score": net.score, "pair": net.pair}
    for k in range(ROUNDS):
        named |= {f"{k}.end": net.ends[k], f"{k}.region": net.regions[k], f"{k}.pair": net.pairs[k]}
    for name, module in named.items():
        for layer, value in module.state_dict().items():  # "weight", or "0.weight" and "2.weight"
            place, _, part = layer.rpartition(".")
            key = name + {"": "", "0": ".in", "2": ".out"}[place] + "." + part[0]
            arrays[key] = value.T if part == "weight" else value
    return arrays


def to_bytes(nets: Sequence[Net]) -> bytes:
    """The weights of all networks in half precision, as a safetensors file."""
    header, body = {}, b""
    arrays = {f"{number}/{name}": value for number, net in enumerate(nets) for name, value in _arrays(net).items()}
    for name, value in sorted(arrays.items()):
        data = np.ascontiguousarray(value.detach().numpy().astype(np.float16)).tobytes()
        header[name] = {"dtype": "F16", "shape": list(value.shape), "data_offsets": [len(body), len(body) + len(data)]}
        body += data
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    return len(text).to_bytes(8, "little") + text + body
