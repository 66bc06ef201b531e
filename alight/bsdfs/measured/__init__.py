"""Reflectances measured on real samples."""
