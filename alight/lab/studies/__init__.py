"""The ready studies, one file each; the numbers order them."""
