"""Who renders blocks of samples: the threads of this process, or a cluster."""
