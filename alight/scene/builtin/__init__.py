"""Scenes that come with alight, one YAML file each: `alight.formats.scene_text.builtin_names`."""
