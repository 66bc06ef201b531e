"""What rough surfaces share: distributions of facets, and how much light they reflect."""
