"""Scenes that come with alight, one YAML file each; see `alight.scene.builtin_names`."""
