"""Settings of the whole test run: no fight for cores, no luck, and no skipped test, which would prove nothing."""

from __future__ import annotations

import os
import shutil

import pytest
from hypothesis import settings

if shutil.which("nvidia-smi") is None:  # kernels for the GPU are interpreted; read when Triton is imported
    os.environ.setdefault("TRITON_INTERPRET", "1")
if "PYTEST_XDIST_WORKER" in os.environ:  # each worker has a core of its own; read before numba and torch are imported
    for name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")


# the verdict on a commit does not depend on luck; --hypothesis-profile=default looks for new cases
settings.register_profile("fixed", derandomize=True)
settings.load_profile("fixed")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Name the skipped tests that should have run, and fail for them; only those that need a CUDA device need not."""
    skipped = [
        report for report in terminalreporter.stats.get("skipped", []) if "cuda" not in getattr(report, "keywords", {})
    ]
    for report in skipped:
        terminalreporter.write_line(f"SKIPPED, and it must not be: {report.nodeid}", red=True)
    if skipped and terminalreporter._session is not None:
        terminalreporter._session.exitstatus = pytest.ExitCode.TESTS_FAILED
