"""From drawing to drawing: strokes of one drawing become strokes with lives over the whole clip."""

from __future__ import annotations

from videovec.propagate.births import Trace
from videovec.propagate.happenings import events_of
from videovec.propagate.inks import propagate
from videovec.propagate.registration import Source, register, source_of
from videovec.propagate.target import Target, make_target
from videovec.propagate.walk import Propagated

__all__ = ["Propagated", "Source", "Target", "Trace", "events_of", "make_target", "propagate", "register", "source_of"]
