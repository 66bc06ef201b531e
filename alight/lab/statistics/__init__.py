"""What replicates say: block means, bias and variance, intervals, speed-ups, odd arms."""
