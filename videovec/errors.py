"""What can go wrong, as one tree.

    VideovecError
    ├── UserError          the user can mend it; exit status 2
    │   ├── InputError     a file or folder that cannot be used
    │   ├── ConfigError    a setting that does not exist or does not fit
    │   └── OutputError    a place that cannot be written
    └── FitError           our fault: a stage broke its own contract; exit status 1

Every message names the thing, what it must be, and what was got.
"""

from __future__ import annotations

__all__ = ["ConfigError", "FitError", "InputError", "OutputError", "UserError", "VideovecError"]


class VideovecError(Exception):
    """Root of all errors that videovec raises on purpose."""


class UserError(VideovecError):
    """Something that the user can mend."""


class InputError(UserError):
    """A file, folder or frame that cannot be used."""


class ConfigError(UserError):
    """A setting, preset or option that does not exist or does not fit."""


class OutputError(UserError):
    """A place that cannot be written to."""


class FitError(VideovecError):
    """A stage broke its own contract."""
