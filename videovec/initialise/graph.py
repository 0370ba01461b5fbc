"""The skeleton as a graph: branches of pixels between the places where they end or meet."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from videovec.compiling import compiled

__all__ = ["Branch", "Graph", "polyline_length", "skeleton_graph"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


_STAIRS = 4  # samples of a skeleton over which its length is taken as straight


def polyline_length(line: Floats) -> float:
    """Length of a run of skeleton samples, without the detours of its staircase. px"""
    coarse = np.concatenate([line[:-1:_STAIRS], line[-1:]])
    return float(np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum())


@dataclass(frozen=True, eq=False)
class Branch:
    """A run of skeleton between two nodes.

    Args:
        start: Node at its first sample.
        stop: Node at its last one; the same as ``start`` for a loop.
        line: Samples in order; the first and the last lie on pixels of the nodes. [M, 2] px
        radius: Distance to the edge of the ink's mask at each sample. [M] px
    """

    start: int
    stop: int
    line: Floats
    radius: Floats

    @cached_property
    def thickness(self) -> float:
        """Median mask radius. px"""
        return float(np.median(self.radius))

    @cached_property
    def length(self) -> float:
        """Length, without the detours of a staircase of pixels. px"""
        return polyline_length(self.line)

    def leaving(self, node: int) -> Branch:
        """The same branch, run so that it starts at one of its nodes."""
        return self if self.start == node else self.reversed()

    def reversed(self) -> Branch:
        """The same branch, run the other way."""
        return Branch(self.stop, self.start, self.line[::-1], self.radius[::-1])


@dataclass(slots=True, eq=False)
class Graph:
    """A skeleton that passes of cleaning work on, one after the other.

    Args:
        position: Where each node lies. [V, 2] px
        radius: Distance to the edge of the ink's mask at each node. [V] px
        branches: Every branch that is left, by its number.
        loops: Closed lines without a node.
        loop_radius: Mask radius of their samples.
        dots: Isolated pixels: where and how far from the edge of the mask. [K, 3] px
    """

    position: Floats
    radius: Floats
    branches: dict[int, Branch]
    loops: list[Floats]
    loop_radius: list[Floats]
    dots: Floats
    _ends: dict[int, list[tuple[int, int]]] = field(init=False)

    def __post_init__(self) -> None:
        self._ends = {}
        for number, branch in self.branches.items():
            self._attach(number, branch)

    def _attach(self, number: int, branch: Branch) -> None:
        self._ends.setdefault(branch.start, []).append((number, 0))
        self._ends.setdefault(branch.stop, []).append((number, 1))

    def ends_at(self, node: int) -> list[tuple[int, int]]:
        """The branch ends at a node, as (branch, 0 for its start or 1 for its stop)."""
        return self._ends.get(node, [])

    def nodes(self) -> list[int]:
        """Nodes at which at least one branch ends."""
        return [node for node, ends in self._ends.items() if ends]

    def degree(self, node: int) -> int:
        """How many branch ends meet at a node; a loop counts twice."""
        return len(self.ends_at(node))

    def outward(self, number: int, end: int) -> Branch:
        """A branch run away from one of its ends."""
        branch = self.branches[number]
        return branch if end == 0 else branch.reversed()

    def remove(self, number: int) -> Branch:
        """Take a branch out; its nodes stay."""
        branch = self.branches.pop(number)
        for node in {branch.start, branch.stop}:
            self._ends[node] = [end for end in self._ends[node] if end[0] != number]
        return branch

    def add(self, branch: Branch) -> int:
        """Put a branch in, and say its number."""
        number = max(self.branches, default=-1) + 1
        self.branches[number] = branch
        self._attach(number, branch)
        return number

    def dissolve(self, node: int) -> None:
        """Join the two branches that meet at a node of degree two into one; a loop at it becomes a closed line."""
        (one, end_one), (two, end_two) = self.ends_at(node)
        if one == two:
            loop = self.remove(one)
            self.loops.append(loop.line)
            self.loop_radius.append(loop.radius)
            return
        before, after = self.outward(one, end_one).reversed(), self.outward(two, end_two)
        self.remove(one)
        self.remove(two)
        line = np.concatenate([before.line, after.line])
        self.add(Branch(before.start, after.stop, line, np.concatenate([before.radius, after.radius])))

    def sharpen(self, node: int, tip: Floats, reach: float) -> None:
        """Let the two branches that meet at a node of degree two run straight on to the tip of a corner.

        Args:
            node: The node.
            tip: Where they should meet. [2] px
            reach: Distance from the tip within which what thinning says of the branches is replaced. px
        """
        for number, end in self.ends_at(node):
            branch = self.outward(number, end)
            far = np.linalg.norm(branch.line - tip, axis=1) > reach
            begin = int(far.argmax()) if far.any() else len(far)
            begin = min(begin, len(far) // 2)
            count = max(int(np.linalg.norm(branch.line[begin] - tip)), 1)
            straight = tip + np.arange(count)[:, None] / count * (branch.line[begin] - tip)
            line = np.concatenate([straight, branch.line[begin:]])
            radius = np.concatenate([np.full(count, branch.radius[begin]), branch.radius[begin:]])
            changed = Branch(branch.start, branch.stop, line, radius)
            self.branches[number] = changed if end == 0 else changed.reversed()
        self.dissolve(node)

    def contract(self, number: int) -> int:
        """Shrink a branch to nothing, so that its two nodes become one; returns that node."""
        branch = self.remove(number)
        kept, gone = branch.start, branch.stop
        if kept == gone:
            return kept
        self.position[kept] = 0.5 * (self.position[kept] + self.position[gone])
        self.radius[kept] = max(self.radius[kept], self.radius[gone])
        for other in {end[0] for end in self.ends_at(gone)}:
            moved = self.remove(other)
            start, stop = (kept if node == gone else node for node in (moved.start, moved.stop))
            self.branches[other] = Branch(start, stop, moved.line, moved.radius)
            self._attach(other, self.branches[other])
        return kept


@compiled()
def _neighbours(index: NDArray[np.int32], pixels: Ints) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Skeleton pixels around each, the four straight ones first; a diagonal counts where no straight one bridges it."""
    table = np.full((len(pixels), 8), -1, np.int32)
    degree = np.zeros(len(pixels), np.int32)
    for i in range(len(pixels)):
        y, x = pixels[i]
        for dy, dx in ((-1, 0), (0, 1), (1, 0), (0, -1)):
            if index[y + dy, x + dx] >= 0:
                table[i, degree[i]] = index[y + dy, x + dx]
                degree[i] += 1
        for dy, dx in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            if index[y + dy, x + dx] >= 0 and index[y + dy, x] < 0 and index[y, x + dx] < 0:
                table[i, degree[i]] = index[y + dy, x + dx]
                degree[i] += 1
    return table, degree


@compiled()
def _walk(
    table: NDArray[np.int32], degree: NDArray[np.int32], node: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Follow every run of pixels between nodes, then every closed run.

    Returns the pixels of all runs, where each run begins (and the last ends), and its two nodes (-1 for closed runs).
    """
    pixels = np.empty(2 * len(node) + 8 * len(node), np.int32)
    starts = np.zeros(len(node) * 4 + 2, np.int32)
    ends = np.empty((len(node) * 4 + 1, 2), np.int32)
    used = np.zeros(len(node), np.bool_)
    filled = 0
    runs = 0
    for i in range(len(node)):
        if node[i] < 0:
            continue
        for k in range(degree[i]):
            previous, here = i, table[i, k]
            if node[here] >= 0 and (node[here] == node[i] or here < i):
                continue
            if node[here] < 0 and used[here]:
                continue
            pixels[filled] = i
            filled += 1
            while node[here] < 0:
                used[here] = True
                pixels[filled] = here
                filled += 1
                step = table[here, 0] if table[here, 0] != previous else table[here, 1]
                previous, here = here, step
            pixels[filled] = here
            filled += 1
            ends[runs, 0], ends[runs, 1] = node[i], node[here]
            runs += 1
            starts[runs] = filled
    for i in range(len(node)):
        if node[i] >= 0 or used[i]:
            continue
        previous, here = i, i
        while not used[here]:
            used[here] = True
            pixels[filled] = here
            filled += 1
            step = table[here, 0] if table[here, 0] != previous else table[here, 1]
            previous, here = here, step
        ends[runs] = -1
        runs += 1
        starts[runs] = filled
    return pixels[:filled], starts[: runs + 1], ends[:runs]


def _node_labels(table: NDArray[np.int32], degree: NDArray[np.int32]) -> tuple[NDArray[np.int32], int]:
    """Number the nodes: ends of lines, and clusters of touching pixels with three or more neighbours. -1 elsewhere."""
    forks = degree >= 3
    one = np.repeat(np.arange(len(table)), 8)
    two = table.ravel()
    touching = (two >= 0) & forks[one] & forks[two]
    shape = (len(table), len(table))
    links = sparse.coo_matrix((np.ones(touching.sum(), bool), (one[touching], two[touching])), shape=shape)
    cluster = sparse.csgraph.connected_components(links, directed=False)[1]
    is_node = forks | (degree <= 1)
    names, labels = np.unique(cluster[is_node], return_inverse=True)
    node = np.full(len(table), -1, np.int32)
    node[is_node] = labels
    return node, len(names)


def skeleton_graph(skeleton: NDArray[np.uint8], radius: NDArray[np.float32], scale: int) -> Graph:
    """Read the graph of a skeleton.

    Args:
        skeleton: Non-zero on the skeleton. [H * scale, W * scale]
        radius: Distance of each pixel to the edge of the mask, in pixels of the skeleton's image.
        scale: Pixels of the skeleton's image per px.

    Returns:
        The graph, in px with pixel centres at +0.5.
    """
    padded = np.pad(skeleton > 0, 1)
    pixels = np.argwhere(padded).astype(np.int64)
    if len(pixels) == 0:
        return Graph(np.zeros((0, 2)), np.zeros(0), {}, [], [], np.zeros((0, 3)))
    index = np.full(padded.shape, -1, np.int32)
    index[pixels[:, 0], pixels[:, 1]] = np.arange(len(pixels))
    table, degree = _neighbours(index, pixels)
    node, count = _node_labels(table, degree)
    where = (pixels[:, ::-1] - 0.5) / scale
    thickness = radius[pixels[:, 0] - 1, pixels[:, 1] - 1].astype(np.float64) / scale
    member = node >= 0
    size = np.bincount(node[member], minlength=count)
    position = np.stack([np.bincount(node[member], where[member, i], count) for i in range(2)], axis=1) / size[:, None]
    node_radius = np.zeros(count)
    np.maximum.at(node_radius, node[member], thickness[member])
    runs, starts, ends = _walk(table, degree, node)
    branches, loops, loop_radius = {}, [], []
    for i, (start, stop) in enumerate(ends):
        run = runs[starts[i] : starts[i + 1]]
        if start < 0:
            loops.append(where[run])
            loop_radius.append(thickness[run])
        else:
            branches[i] = Branch(int(start), int(stop), where[run], thickness[run])
    dots = np.concatenate([where, thickness[:, None]], axis=1)[degree == 0]
    return Graph(position, node_radius, branches, loops, loop_radius, dots)
