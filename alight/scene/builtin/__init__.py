"""Scenes that come with alight, one YAML file each; see `alight.formats.scene_text.builtin_names`."""
