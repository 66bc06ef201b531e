"""What readers of all formats share: which files they may read, places, reports."""
