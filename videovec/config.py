"""From presets and ``key=value`` to a checked configuration.

The settings themselves, their defaults and their meanings stand in ``videovec.settings``; this module knows none of
them by name and finds everything by looking at the dataclasses.
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
import types
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import yaml

from videovec.errors import ConfigError
from videovec.limits import Between, OneOf
from videovec.settings import Config

__all__ = ["Setting", "configure", "describe_settings", "flatten", "preset_names", "suggestion", "validate"]

_TRUE = {"true", "yes", "on", "1"}
_FALSE = {"false", "no", "off", "0"}
_NONE = {"none", "null", ""}


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting: its dotted key, the type of its values, its default and its meaning."""

    key: str
    kind: Any
    default: object
    meaning: str

    @property
    def kind_name(self) -> str:
        """The type in words."""
        kind, limits = _bare(self.kind)
        words = [" | ".join(limit.words) for limit in limits if isinstance(limit, OneOf)]
        return words[0] if words else kind.__name__ if isinstance(kind, type) else str(kind)


def configure(
    preset: str | Path | None = None, overrides: Iterable[str] | Mapping[str, object] = (), base: Config | None = None
) -> Config:
    """A configuration: the defaults, changed by a preset, changed by overrides.

    Args:
        preset: Name of a file in ``configs/``, or the path of a YAML file.
        overrides: ``key=value`` texts such as ``fit.steps=300``, or a mapping of such keys.
        base: What to start from instead of the defaults.

    Raises:
        ConfigError: A preset or setting does not exist, or a value does not fit.
    """
    config = base or Config()
    if preset is not None:
        for key, value in flatten(_read_preset(preset)):
            config = _with_value(config, key, value)
    pairs = overrides.items() if isinstance(overrides, Mapping) else map(_split, overrides)
    for key, value in pairs:
        config = _with_value(config, key, value)
    return config


def validate(config: Config) -> None:
    """Check every value of a configuration that was made by hand.

    Raises:
        ConfigError: A value does not fit.
    """
    for setting in _settings_of(type(config), config):
        _convert(setting.key, setting.default, setting.kind)


def describe_settings(config: Config | None = None) -> tuple[Setting, ...]:
    """Every setting, in the order of the stages; with the values of ``config`` where one is given."""
    return tuple(_settings_of(Config, config or Config()))


def preset_names() -> tuple[str, ...]:
    """The presets that come with videovec."""
    folder = files("videovec.configs")
    return tuple(sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".yaml")))


def flatten(tree: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Dotted keys and values of nested settings."""
    for name, value in tree.items():
        key = f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from flatten(value, f"{key}.")
        else:
            yield key, value


def suggestion(name: str, names: Iterable[str]) -> str:
    """The end of a message about a name that does not exist: the name that may have been meant, or nothing."""
    close = get_close_matches(name, list(names), 1)
    return f"; did you mean '{close[0]}'?" if close else ""


def _read_preset(preset: str | Path) -> dict[str, object]:
    path = Path(preset)
    if path.suffix in {".yaml", ".yml"}:
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"cannot read preset {path}: {error}") from error
    elif str(preset) in preset_names():
        text = (files("videovec.configs") / f"{preset}.yaml").read_text(encoding="utf-8")
    else:
        hint = suggestion(str(preset), preset_names()) or f"; there are {', '.join(preset_names())}"
        raise ConfigError(f"unknown preset {preset}{hint}")
    try:
        content = yaml.safe_load(text) or {}
    except yaml.YAMLError as error:
        raise ConfigError(f"preset {preset} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise ConfigError(f"preset {preset} must map settings to values, got {type(content).__name__}")
    return content


def _split(text: str) -> tuple[str, object]:
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise ConfigError(f"a setting is given as key=value, got {text!r}")
    return key.strip(), value.strip()


def _with_value(settings: Any, key: str, value: object, prefix: str = "") -> Any:
    """The same settings with one value changed, however deep it lies."""
    name, _, rest = key.partition(".")
    hints = _hints(type(settings))
    if name not in hints:
        raise ConfigError(f"unknown setting {prefix}{key}{_hint_for(name, tuple(hints), prefix)}")
    kind = hints[name]
    path = f"{prefix}{name}"
    if is_dataclass(kind):
        if not rest:
            inside = ", ".join(f"{path}.{inner}" for inner in _hints(kind))
            raise ConfigError(f"{path} is a group of settings, set one of {inside}")
        changed = _with_value(getattr(settings, name), rest, value, f"{path}.")
    elif rest:
        raise ConfigError(f"unknown setting {prefix}{key}; {path} is a single value")
    else:
        changed = _convert(path, value, kind)
    return replace(settings, **{name: changed})


def _hint_for(name: str, siblings: tuple[str, ...], prefix: str) -> str:
    """A setting that may have been meant: one close by, or one of this name elsewhere."""
    if near := suggestion(name, siblings):
        return near
    keys = [setting.key for setting in describe_settings()]
    same = [key for key in keys if key.rpartition(".")[2] == name]
    if same:
        return f"; did you mean '{same[0]}'?"
    leaves = {key.rpartition(".")[2]: key for key in keys}
    close = get_close_matches(name, leaves, 1)
    if close:
        return f"; did you mean '{leaves[close[0]]}'?"
    return f"; {prefix.rstrip('.') or 'videovec'} has {', '.join(siblings)}"


def _hints(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


def _bare(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    """A type without its limits, and the limits."""
    return (kind.__origin__, kind.__metadata__) if get_origin(kind) is Annotated else (kind, ())


def _convert(key: str, value: object, kind: Any) -> object:
    """A value as its setting's type, checked against the limits; texts are read as that type."""
    kind, limits = _bare(kind)
    if get_origin(kind) in (Union, types.UnionType):
        options = [option for option in get_args(kind) if option is not types.NoneType]
        if value is None or (isinstance(value, str) and value.lower() in _NONE):
            return None
        return _convert(key, value, Annotated[options[0], *limits] if limits else options[0])
    if get_origin(kind) is tuple:
        items = value.split(",") if isinstance(value, str) else value
        if not isinstance(items, list | tuple):
            raise ConfigError(f"{key} must be a list, got {value!r}")
        return tuple(_convert(key, item, get_args(kind)[0]) for item in items)
    converted = _READERS[kind](value)
    if converted is None:
        raise ConfigError(f"{key} must be {_WORDS[kind]}, got {value!r}")
    for limit in limits:
        if isinstance(limit, Between | OneOf) and (problem := limit.problem(converted)):
            raise ConfigError(f"{key} must be {problem}, got {value!r}")
    return converted


def _read_bool(value: object) -> bool | None:
    if isinstance(value, bool):
        return value
    word = str(value).lower()
    return True if word in _TRUE else False if word in _FALSE else None


def _read_int(value: object) -> int | None:
    number = _read_float(value)
    return int(number) if number is not None and number == int(number) else None


def _read_float(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _read_str(value: object) -> str | None:
    return value if isinstance(value, str) else None


_READERS: dict[type, Any] = {bool: _read_bool, int: _read_int, float: _read_float, str: _read_str}
_WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


def _settings_of(kind: type, values: object, prefix: str = "") -> Iterator[Setting]:
    meanings = _meanings(kind)
    for name, hint in _hints(kind).items():
        value = getattr(values, name)
        if is_dataclass(hint):
            yield from _settings_of(type(value), value, f"{prefix}{name}.")
        else:
            yield Setting(f"{prefix}{name}", hint, value, meanings.get(name, ""))


def _meanings(kind: type) -> dict[str, str]:
    """The text under each field of a class, which Python itself does not keep."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for field, text in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(text, ast.Expr):
            found[field.target.id] = " ".join(str(ast.literal_eval(text.value)).split())
    return found
