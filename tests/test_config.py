"""Presets and overrides become a checked configuration, or an error that says what to do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from videovec.config import configure, describe_settings, preset_names, validate
from videovec.errors import ConfigError
from videovec.settings import Config, FitSettings


def test_nothing_given_is_the_defaults() -> None:
    assert configure() == Config()


def test_an_override_changes_its_setting_alone() -> None:
    config = configure(overrides=["fit.steps=300"])
    assert config.fit.steps == 300
    assert replace(config, fit=Config().fit) == Config()


def test_overrides_win_over_the_preset_and_the_last_override_wins(tmp_path: Path) -> None:
    preset = tmp_path / "mine.yaml"
    preset.write_text("fit: {steps: 7, weights: {acceleration: 0.5}}\nseed: 3\n")
    config = configure(preset, ["fit.steps=8", "fit.steps=9"])
    assert (config.fit.steps, config.fit.weights.acceleration, config.seed) == (9, 0.5, 3)


def test_a_mapping_serves_as_overrides() -> None:
    assert configure(overrides={"fit.steps": 5, "render.device": "cpu"}).render.device == "cpu"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("fit.stpes=3", "unknown setting fit.stpes; did you mean 'steps'?"),
        ("fti.steps=3", "unknown setting fti.steps; did you mean 'fit'?"),
        ("steps=3", "unknown setting steps; did you mean 'fit.steps'?"),
        ("fit.steps=many", "fit.steps must be a whole number, got 'many'"),
        ("fit.steps=1.5", "fit.steps must be a whole number, got '1.5'"),
        ("fit.steps=-1", "fit.steps must be at least 0, got '-1'"),
        ("initialise.max_turn=900", "initialise.max_turn must be between 0 and 180, got '900'"),
        ("initialise.tolerance=nan", "initialise.tolerance must be a number, got 'nan'"),
        ("render.backend=gpu", "render.backend must be one of auto, numba, torch, reference, got 'gpu'"),
        ("ink.flatten=maybe", "ink.flatten must be true or false, got 'maybe'"),
        ("fit.steps.more=1", "unknown setting fit.steps.more; fit.steps is a single value"),
        ("fit=1", "fit is a group of settings"),
        ("fit.steps", "a setting is given as key=value, got 'fit.steps'"),
        ("=3", "a setting is given as key=value"),
    ],
)
def test_a_wrong_override_is_one_clear_error(override: str, message: str) -> None:
    with pytest.raises(ConfigError) as error:
        configure(overrides=[override])
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("fit: {stpes: 1}", "unknown setting fit.stpes; did you mean 'steps'?"),
        ("fit: [1, 2]", "fit is a group of settings"),
        ("- 1", "must map settings to values, got list"),
        ("fit: {", "is not YAML"),
        ("seed: true", "seed must be a whole number, got True"),
    ],
)
def test_a_wrong_preset_is_one_clear_error(tmp_path: Path, text: str, message: str) -> None:
    preset = tmp_path / "mine.yaml"
    preset.write_text(text)
    with pytest.raises(ConfigError) as error:
        configure(preset)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_preset_suggests_one_and_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"unknown preset soild; did you mean 'solid'\?"):
        configure("soild")
    with pytest.raises(ConfigError, match=r"cannot read preset .*gone\.yaml"):
        configure(tmp_path / "gone.yaml")


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_is_valid_and_says_only_what_it_changes(name: str) -> None:
    text = (Path(__file__).parents[1] / "configs" / f"{name}.yaml").read_text(encoding="utf-8")
    assert text.startswith("#"), "a preset begins by saying what it is for"
    default, changed = describe_settings(), describe_settings(configure(name))
    told = len([key for key in _leaves(yaml.safe_load(text)) if key != "pipeline"])
    different = [old.key for old, new in zip(default, changed, strict=True) if old.default != new.default]
    assert told == len([key for key in different if key != "pipeline"])


def _leaves(tree: dict[str, object]) -> list[str]:
    return [leaf for key, value in tree.items() for leaf in (_leaves(value) if isinstance(value, dict) else [key])]


def test_every_setting_says_what_it_means_and_its_default_is_valid() -> None:
    for setting in describe_settings():
        assert setting.meaning, f"{setting.key} has no text under it"
    validate(Config())


def test_a_configuration_made_by_hand_is_checked_too() -> None:
    with pytest.raises(ConfigError, match=r"fit\.steps must be at least 0"):
        validate(Config(fit=FitSettings(steps=-3)))


@given(st.floats(min_value=0, max_value=1e12, allow_nan=False))
def test_numbers_survive_being_written_as_text(value: float) -> None:
    assert configure(overrides=[f"fit.weights.curvature={value!r}"]).fit.weights.curvature == value
