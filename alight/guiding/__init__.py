"""Path guiding: where light comes from, learnt before the picture is rendered."""
