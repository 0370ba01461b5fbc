"""Line-art clips to Bézier strokes with one identity over the whole clip.

Everything here is imported when it is first used, so that ``import videovec`` is fast.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from videovec.clip import Clip, Timeline
    from videovec.config import configure
    from videovec.correction import correct
    from videovec.decode import decode
    from videovec.errors import ConfigError, FitError, InputError, OutputError, UserError, VideovecError
    from videovec.events import Event, EventKind
    from videovec.export import export
    from videovec.fit import fit
    from videovec.initialise import initialise
    from videovec.ink import Ink, extract_ink
    from videovec.picture import render_strokes
    from videovec.propagate import propagate
    from videovec.reference import read_reference
    from videovec.run import run, track
    from videovec.settings import Config
    from videovec.strokes import Strokes
    from videovec.tracks import StrokeTracks

__version__ = "0.1.0"

__all__ = [
    "Clip",
    "Config",
    "ConfigError",
    "Event",
    "EventKind",
    "FitError",
    "Ink",
    "InputError",
    "OutputError",
    "StrokeTracks",
    "Strokes",
    "Timeline",
    "UserError",
    "VideovecError",
    "configure",
    "correct",
    "decode",
    "export",
    "extract_ink",
    "fit",
    "initialise",
    "propagate",
    "read_reference",
    "render_strokes",
    "run",
    "track",
]

_HOME = {
    "Clip": "clip",
    "Config": "settings",
    "ConfigError": "errors",
    "Event": "events",
    "EventKind": "events",
    "FitError": "errors",
    "Ink": "ink",
    "InputError": "errors",
    "OutputError": "errors",
    "StrokeTracks": "tracks",
    "Strokes": "strokes",
    "Timeline": "clip",
    "UserError": "errors",
    "VideovecError": "errors",
    "configure": "config",
    "correct": "correction",
    "decode": "decode",
    "export": "export",
    "extract_ink": "ink",
    "fit": "fit",
    "initialise": "initialise",
    "propagate": "propagate",
    "read_reference": "reference",
    "render_strokes": "picture",
    "run": "run",
    "track": "run",
}
"""Module of each public name."""


class _Package(ModuleType):
    """This package: imports what is asked for, and keeps a function above the module of the same name."""

    def __getattr__(self, name: str) -> object:
        """Import a public name when it is first asked for."""
        if name not in _HOME:
            raise AttributeError(f"module 'videovec' has no attribute {name!r}")
        return getattr(import_module(f"videovec.{_HOME[name]}"), name)

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute, unless an import would put the module ``run`` in the place of the function ``run``."""
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """The public names."""
        return [*__all__, "__version__"]


sys.modules[__name__].__class__ = _Package
