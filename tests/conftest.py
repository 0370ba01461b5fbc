"""A test that is skipped proves nothing: only tests that need a CUDA device may be."""

from __future__ import annotations

import pytest


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Name the skipped tests that should have run, and fail for them."""
    skipped = [
        report for report in terminalreporter.stats.get("skipped", []) if "cuda" not in getattr(report, "keywords", {})
    ]
    for report in skipped:
        terminalreporter.write_line(f"SKIPPED, and it must not be: {report.nodeid}", red=True)
    if skipped and terminalreporter._session is not None:
        terminalreporter._session.exitstatus = pytest.ExitCode.TESTS_FAILED
